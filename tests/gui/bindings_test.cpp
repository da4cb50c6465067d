// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <QKeyEvent>
#include <QKeySequence>

#include "gui/input/bindings.h"
#include "gui/input/help.h"

namespace simplexseg {
namespace {

bool overlap(Where a, Where b) { return a == b || a == Where::Everywhere || b == Where::Everywhere; }

TEST(Bindings, NoTriggerMeansTwoThings) {
  const auto table = bindings();
  for (std::size_t a = 0; a < table.size(); ++a) {
    for (std::size_t b = a + 1; b < table.size(); ++b) {
      if (!overlap(table[a].where, table[b].where)) continue;
      const bool same_keys = *table[a].keys && QKeySequence(table[a].keys) == QKeySequence(table[b].keys);
      const bool same_mouse =
          table[a].mouse != Mouse::None && table[a].mouse == table[b].mouse && table[a].modifiers == table[b].modifiers;
      EXPECT_FALSE(same_keys || same_mouse) << table[a].does << " / " << table[b].does;
    }
  }
}

TEST(Bindings, EveryRowHasATriggerAndADescription) {
  for (const Binding& binding : bindings()) {
    EXPECT_NE(*binding.keys != 0, binding.mouse != Mouse::None) << binding.does;
    EXPECT_NE(*binding.does, 0);
    EXPECT_TRUE(!*binding.keys || !QKeySequence(binding.keys).isEmpty()) << binding.keys;
    // What can be used everywhere is in a menu, so it has a title.
    EXPECT_EQ(binding.where == Where::Everywhere, *binding.title != 0) << binding.does;
  }
}

TEST(Bindings, HelpListsEveryRow) {
  const QString html = bindings_html();
  for (const Binding& binding : bindings()) {
    EXPECT_TRUE(html.contains(QString::fromUtf8(binding.does).toHtmlEscaped())) << binding.does;
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
