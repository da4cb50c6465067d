// SPDX-License-Identifier: Apache-2.0
// Changed keys: assignment, files, dialog, and where the keys appear. Tests send key events.
#include <QAction>
#include <QDialogButtonBox>
#include <QFile>
#include <QKeySequenceEdit>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSettings>
#include <QTest>
#include <QTreeWidget>

#include "core/error.h"
#include "gui/input/help.h"
#include "gui/input/key_map.h"
#include "gui/window/key_dialog.h"
#include "gui/window/key_file.h"
#include "gui/window/key_settings.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

QKeySequence key_named(const char* text) { return QKeySequence(QString::fromLatin1(text)); }

std::string refusal_of_keys(const std::string& text) {
  try {
    keys_of_json(text, "keys.json");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(KeyAssignments, KeepOnlyDifferencesAndNoKeyTwice) {
  KeyAssignment keys;
  EXPECT_EQ(keys.key_of(Act::ToolFreeze), key_named("K"));
  keys.set(Act::ToolFreeze, key_named("F11"));
  EXPECT_TRUE(keys.is_changed(Act::ToolFreeze));
  EXPECT_FALSE(keys.act_with(key_named("K")));
  keys.set(Act::Lasso, key_named("F11"));  // takes it over
  EXPECT_TRUE(keys.key_of(Act::ToolFreeze).isEmpty());
  EXPECT_EQ(keys.act_with(key_named("F11")), Act::Lasso);
  keys.reset(Act::Lasso);
  EXPECT_FALSE(keys.is_changed(Act::Lasso));
  keys.set(Act::ToolFreeze, key_named("I"));  // of the slices
  EXPECT_TRUE(keys.key_of(Act::AddInside).isEmpty());
  keys.reset(Act::AddInside);
  EXPECT_TRUE(keys.key_of(Act::ToolFreeze).isEmpty()) << "a default is taken over as well";
  keys.reset_all();
  EXPECT_TRUE(keys.is_default());
  for (const char* refused : {"Tab", "Return", "Alt+F", "Ctrl+K, Ctrl+L"}) keys.set(Act::Lasso, key_named(refused));
  EXPECT_TRUE(keys.is_default()) << "refused keys change nothing";
}

TEST(KeyAssignments, AreWrittenAndReadAndBadFilesAreOneLine) {
  KeyAssignment keys;
  keys.set(Act::ToolBrush, key_named("Ctrl+Shift+F12"));
  keys.set(Act::Lasso, key_named("K"));
  keys.set(Act::RunPause, {});
  const std::string text = keys_json(keys);
  EXPECT_EQ(keys_of_json(text, "keys.json"), keys);
  EXPECT_NE(text.find("\"ToolFreeze\": \"\""), std::string::npos) << text;
  EXPECT_EQ(text.find("ToolSeed"), std::string::npos) << "only what differs: " << text;
  const std::pair<const char*, const char*> cases[] = {
      {"", "line 1"},
      {"{", "line 1"},
      {"[]", "object"},
      {"{\"keys\": {}}", "simplexseg_keys"},
      {"{\"simplexseg_keys\": 2, \"keys\": {}}", "simplexseg_keys"},
      {"{\"simplexseg_keys\": 1}", "keys"},
      {"{\"simplexseg_keys\": 1, \"keys\": [], \"x\": 1}", "'x'"},
      {"{\"simplexseg_keys\": 1, \"keys\": {\"ToolBrsh\": \"P\"}}", "ToolBrush"},
      {"{\"simplexseg_keys\": 1, \"keys\": {\"Zoom\": \"P\"}}", "Zoom"},
      {"{\"simplexseg_keys\": 1, \"keys\": {\"ToolBrush\": 3}}", "ToolBrush"},
      {"{\"simplexseg_keys\": 1, \"keys\": {\"ToolBrush\": \"no key\"}}", "no key"},
      {"{\"simplexseg_keys\": 1, \"keys\": {\"ToolBrush\": \"Tab\"}}", "focus"},
      {"{\"simplexseg_keys\": 1, \"keys\": {\"ToolBrush\": \"K\"}}", "same key"},
      {"{\"simplexseg_keys\": 1, \"keys\": {\"ToolBrush\": \"F12\", \"ToolBrush\": \"F11\"}}", "twice"}};
  for (const auto& [bad, expected] : cases) {
    const std::string message = refusal_of_keys(bad);
    EXPECT_NE(message.find(expected), std::string::npos) << bad << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_NE(message.find("keys.json"), std::string::npos) << message;
  }
}

class KeyDialogTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    ASSERT_TRUE(has_keys());
  }
  void TearDown() override {
    KeyMap::shared().assign({});
    PausedPhantomTest::TearDown();
  }
  KeyDialog& open() {
    window_->actions()[Act::ChangeKeys]->trigger();
    EXPECT_TRUE(wait_until([&] { return dialog() && dialog()->isActiveWindow(); }));
    return *dialog();
  }
  KeyDialog* dialog() { return window_->findChild<KeyDialog*>(); }
  QTreeWidgetItem* row_of(Act act) {
    auto& list = *dialog()->findChild<QTreeWidget*>();
    for (int g = 0; g < list.topLevelItemCount(); ++g)
      for (int n = 0; n < list.topLevelItem(g)->childCount(); ++n)
        if (list.topLevelItem(g)->child(n)->data(0, Qt::UserRole).toInt() == static_cast<int>(act))
          return list.topLevelItem(g)->child(n);
    return nullptr;
  }
  void select(Act act) { dialog()->findChild<QTreeWidget*>()->setCurrentItem(row_of(act)); }
  /// Selects an act and presses a key in the field.
  void enter(Act act, Qt::Key key, Qt::KeyboardModifiers modifiers = {}) {
    select(act);
    auto* edit = dialog()->findChild<QKeySequenceEdit*>();
    edit->setFocus();
    QTest::keyClick(edit, key, modifiers);
  }
  QString message() { return dialog()->findChild<QLabel*>("key_message")->text(); }
  QPushButton& take_over() { return *dialog()->findChild<QPushButton*>("take_over"); }
  void close_with(QDialogButtonBox::StandardButton button) {
    QTest::mouseClick(dialog()->findChild<QDialogButtonBox*>()->button(button), Qt::LeftButton);
    EXPECT_TRUE(wait_until([&] { return !dialog(); }));
    ASSERT_TRUE(has_keys());
  }
  void press(Qt::Key key) { QTest::keyClick(window_->windowHandle(), key); }
};

TEST_F(KeyDialogTest, AChangedKeyActsAndAppearsEverywhere) {
  open();
  enter(Act::ToolBrush, Qt::Key_F11);
  EXPECT_EQ(message(), "");
  EXPECT_EQ(row_of(Act::ToolBrush)->text(1), "F11");
  EXPECT_EQ(row_of(Act::ToolBrush)->text(2), "B");
  press(Qt::Key_F11);
  EXPECT_EQ(bench().view.tool, Tool::Crosshair) << "not before OK";
  close_with(QDialogButtonBox::Ok);
  press(Qt::Key_F11);
  EXPECT_EQ(bench().view.tool, Tool::Brush);
  press(Qt::Key_1);
  press(Qt::Key_B);
  EXPECT_EQ(bench().view.tool, Tool::Crosshair) << "the former key has no effect";
  const QAction* action = window_->actions()[Act::ToolBrush];
  EXPECT_EQ(action->shortcut(), key_named("F11"));
  EXPECT_TRUE(action->toolTip().contains("(F11)")) << action->toolTip().toStdString();
  EXPECT_TRUE(bindings_html().contains("<b>F11</b>"));
  EXPECT_FALSE(bindings_html().contains("<b>B</b>"));
}

TEST_F(KeyDialogTest, KeysOfTheSlicesAndHeldModesChangeToo) {
  open();
  enter(Act::AddInside, Qt::Key_Z);
  enter(Act::NextSlice, Qt::Key_Home);
  enter(Act::Lasso, Qt::Key_U, Qt::ShiftModifier);
  close_with(QDialogButtonBox::Ok);
  mouse(axial(), QEvent::MouseMove, axial().pixel_of(bench().view.crosshair_mm), Qt::NoButton, Qt::NoButton);
  QTest::keyClick(&axial(), Qt::Key_I);
  EXPECT_TRUE(scene().points.empty());
  QTest::keyClick(&axial(), Qt::Key_Z);
  ASSERT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(scene().points[0].kind, MarkKind::Inside);
  const double before = bench().view.crosshair_mm.z();
  QTest::keyClick(&axial(), Qt::Key_Home);
  EXPECT_NEAR(bench().view.crosshair_mm.z(), before + 1, 1e-9);
  QTest::keyClick(window_->windowHandle(), Qt::Key_U, Qt::ShiftModifier);
  EXPECT_TRUE(bench().view.lasso);
}

TEST_F(KeyDialogTest, AKeyOfAnotherActionIsTakenOverOnRequest) {
  open();
  enter(Act::Lasso, Qt::Key_K);
  EXPECT_TRUE(message().contains("'Freeze'")) << message().toStdString();
  EXPECT_EQ(row_of(Act::Lasso)->text(1), "Q") << "not without consent";
  ASSERT_TRUE(take_over().isVisible());
  select(Act::Undo);
  EXPECT_FALSE(take_over().isVisible());
  enter(Act::Lasso, Qt::Key_K);
  QTest::mouseClick(&take_over(), Qt::LeftButton);
  EXPECT_EQ(row_of(Act::Lasso)->text(1), "K");
  EXPECT_EQ(row_of(Act::ToolFreeze)->text(1), "none");
  enter(Act::Lasso, Qt::Key_F, Qt::AltModifier);
  EXPECT_TRUE(message().contains("menus")) << message().toStdString();
  EXPECT_EQ(row_of(Act::Lasso)->text(1), "K");
  close_with(QDialogButtonBox::Ok);
  press(Qt::Key_K);
  EXPECT_TRUE(bench().view.lasso);
  EXPECT_NE(bench().view.tool, Tool::Freeze);
  EXPECT_FALSE(window_->actions()[Act::ToolFreeze]->toolTip().contains("(")) << "no key, no brackets";
}

TEST_F(KeyDialogTest, OneKeyOrAllAreResetAndCancelChangesNothing) {
  open();
  enter(Act::ToolBrush, Qt::Key_F11);
  enter(Act::ToolEraser, Qt::Key_F12);
  select(Act::ToolBrush);
  const auto button = [&](const QString& text) -> QPushButton* {
    for (QPushButton* one : dialog()->findChildren<QPushButton*>())
      if (one->text().remove('&') == text) return one;
    return nullptr;
  };
  QTest::mouseClick(button("Default"), Qt::LeftButton);
  EXPECT_EQ(row_of(Act::ToolBrush)->text(1), "B");
  EXPECT_EQ(row_of(Act::ToolEraser)->text(1), "F12");
  QTest::mouseClick(button("No key"), Qt::LeftButton);
  EXPECT_EQ(row_of(Act::ToolBrush)->text(1), "none");
  QTest::mouseClick(button("All defaults"), Qt::LeftButton);
  EXPECT_TRUE(dialog()->keys().is_default());
  enter(Act::ToolBrush, Qt::Key_F11);
  close_with(QDialogButtonBox::Cancel);
  EXPECT_TRUE(KeyMap::shared().keys().is_default());
}

TEST_F(KeyDialogTest, ListsEveryKeyAndIsSearched) {
  open();
  for (const Binding& binding : bindings())
    if (*binding.keys) {
      EXPECT_NE(row_of(binding.act), nullptr) << binding.help;
    }
  QTest::keyClicks(dialog()->findChild<QLineEdit*>(), "lasso");
  EXPECT_FALSE(row_of(Act::Lasso)->isHidden());
  EXPECT_TRUE(row_of(Act::Undo)->isHidden());
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) {
    dialog()->findChild<QLineEdit*>()->clear();
    enter(Act::Lasso, Qt::Key_K);
    dialog()->grab().save(QString(folder) + "/keys.png");
  }
  close_with(QDialogButtonBox::Cancel);
}

TEST_F(KeyDialogTest, KeysAreExportedAndImported) {
  open();
  enter(Act::ToolBrush, Qt::Key_F11);
  const QString path = folder_.filePath("Schlüssel.json");
  dialog()->export_to(path);
  ASSERT_TRUE(QFile::exists(path)) << message().toStdString();
  enter(Act::ToolBrush, Qt::Key_F12);
  dialog()->import_from(path);
  EXPECT_EQ(row_of(Act::ToolBrush)->text(1), "F11");
  QFile bad(folder_.filePath("bad.json"));
  ASSERT_TRUE(bad.open(QIODevice::WriteOnly));
  bad.write("{\"simplexseg_keys\": 1, \"keys\": {\"ToolBrush\": \"K\"}}");
  bad.close();
  dialog()->import_from(bad.fileName());
  EXPECT_TRUE(message().contains("same key")) << message().toStdString();
  EXPECT_EQ(row_of(Act::ToolBrush)->text(1), "F11") << "nothing is lost";
  dialog()->export_to(folder_.filePath("none/keys.json"));
  EXPECT_FALSE(message().contains("Exported")) << message().toStdString();
  close_with(QDialogButtonBox::Cancel);
}

TEST_F(KeyDialogTest, ChangedKeysAreRemembered) {
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, folder_.path());
  {
    KeySettings settings;
    EXPECT_EQ(settings.fault(), "");
    KeyAssignment keys;
    keys.set(Act::ToolBrush, key_named("F11"));
    KeyMap::shared().assign(keys);
  }
  KeyMap::shared().assign({});
  {
    KeySettings settings;
    EXPECT_EQ(window_->actions()[Act::ToolBrush]->shortcut(), key_named("F11"));
    KeyMap::shared().assign({});
  }
  KeySettings settings;
  EXPECT_TRUE(KeyMap::shared().keys().is_default()) << "defaults are not stored";
  QSettings stored(QSettings::IniFormat, QSettings::UserScope, "simplexseg", "keys");
  stored.setValue("changed_keys", "{}");
  stored.sync();
  KeySettings damaged;
  EXPECT_TRUE(damaged.fault().contains("simplexseg_keys")) << damaged.fault().toStdString();
  EXPECT_TRUE(KeyMap::shared().keys().is_default());
}

}  // namespace
}  // namespace simplexseg
