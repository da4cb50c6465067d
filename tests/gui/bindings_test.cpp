// SPDX-License-Identifier: Apache-2.0
// Table of key and mouse bindings, and the help that is made from it.
#include <gtest/gtest.h>

#include <QKeyEvent>
#include <QKeySequence>

#include "gui/input/bindings.h"
#include "gui/input/help.h"

namespace simplexseg {
namespace {

bool overlap(Where a, Where b) { return a == b || a == Where::Everywhere || b == Where::Everywhere; }

TEST(Bindings, NoTriggerIsBoundTwice) {
  const auto table = bindings();
  for (std::size_t a = 0; a < table.size(); ++a) {
    for (std::size_t b = a + 1; b < table.size(); ++b) {
      if (!overlap(table[a].where, table[b].where)) continue;
      const bool same_keys = *table[a].keys && QKeySequence(table[a].keys) == QKeySequence(table[b].keys);
      const bool same_mouse =
          table[a].mouse != Mouse::None && table[a].mouse == table[b].mouse && table[a].modifiers == table[b].modifiers;
      EXPECT_FALSE(same_keys || same_mouse) << table[a].help << " / " << table[b].help;
    }
  }
}

TEST(Bindings, EveryRowHasATriggerAndADescription) {
  for (const Binding& binding : bindings()) {
    EXPECT_NE(*binding.keys != 0, binding.mouse != Mouse::None) << binding.help;
    EXPECT_NE(*binding.help, 0);
    EXPECT_TRUE(!*binding.keys || !QKeySequence(binding.keys).isEmpty()) << binding.keys;
    // Bindings of scope Everywhere are menu entries and have a title.
    EXPECT_EQ(binding.where == Where::Everywhere, *binding.title != 0) << binding.help;
  }
}

TEST(Bindings, HelpListsEveryRow) {
  const QString html = bindings_html();
  for (const Binding& binding : bindings()) {
    EXPECT_TRUE(html.contains(QString::fromUtf8(binding.help).toHtmlEscaped())) << binding.help;
  }
}

TEST(Bindings, GesturesAreLookedUpWithTheirModifiers) {
  EXPECT_EQ(gesture(Where::Slices, Mouse::Left, {}), Act::MoveCrosshair);
  EXPECT_EQ(gesture(Where::Slices, Mouse::Left, Qt::ShiftModifier), Act::AddPoint);
  EXPECT_EQ(gesture(Where::Slices, Mouse::Wheel, Qt::ControlModifier), Act::WheelZoom);
  EXPECT_EQ(gesture(Where::Space, Mouse::Left, {}), Act::Rotate);
  EXPECT_EQ(gesture(Where::Slices, Mouse::Left, Qt::ShiftModifier | Qt::ControlModifier), Act::ErasePoint);
  EXPECT_EQ(gesture(Where::Slices, Mouse::Left, Qt::ShiftModifier | Qt::AltModifier), std::nullopt);
  EXPECT_EQ(key_in(Where::Slices, QKeyEvent(QEvent::KeyPress, Qt::Key_Left, Qt::ShiftModifier | Qt::KeypadModifier)),
            Act::CrosshairLeft5);
  EXPECT_EQ(key_in(Where::Space, QKeyEvent(QEvent::KeyPress, Qt::Key_Left, Qt::NoModifier)), std::nullopt);
}

}  // namespace
}  // namespace simplexseg
