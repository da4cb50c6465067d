// SPDX-License-Identifier: Apache-2.0
// Names from label presets: at the seed, on the card, and in the menu.
#include <QAction>
#include <QDir>
#include <QFile>
#include <QListWidget>
#include <QMenu>
#include <QTest>

#include "gui/panels/label_preset_menu.h"
#include "gui/panels/mesh_card.h"
#include "gui/window/message_bar.h"
#include "gui/window/name_popup.h"
#include "gui/workbench/name_line.h"
#include "gui/workbench/naming.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class NamesTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    ASSERT_TRUE(has_keys());
  }
  void press(Qt::Key key) { QTest::keyClick(window_->windowHandle(), key); }
  void type(const char* text) {
    for (const char* key = text; *key; ++key) QTest::keyClick(window_->windowHandle(), *key);
  }
  NamePopup& popup() { return *window_->findChild<NamePopup*>("name_popup"); }
  NameLine& card_name() { return *window_->findChild<MeshCard*>()->findChild<NameLine*>(); }
  /// Drags a seed beside the phantom's mesh with the tool of key 4.
  void place_seed() {
    press(Qt::Key_4);
    const auto pixel = [&](double x_mm) {
      return axial().pixel_of(bench().view.crosshair_mm + Eigen::Vector3d(x_mm, 20, 0));
    };
    drag(axial(), pixel(0), pixel(6));
    QApplication::processEvents();
  }
  std::size_t undos() { return bench().session().history().undo_names().size(); }
  bool in_views() { return QApplication::focusWidget() && qobject_cast<View*>(QApplication::focusWidget()); }
};

TEST_F(NamesTest, TwoLettersAtTheSeedNameTheSegmentation) {
  ASSERT_TRUE(choose_label_preset(bench(), "abdomen"));
  place_seed();
  ASSERT_TRUE(popup().isVisible());
  EXPECT_EQ(QApplication::focusWidget(), &popup().line());
  const std::size_t before = undos();
  type("lk");
  ASSERT_TRUE(popup().line().list().isVisible());
  EXPECT_EQ(popup().line().list().item(0)->text(), "Left kidney");
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES"))
    window_->grab().save(QString(folder) + "/name_popup.png");
  press(Qt::Key_Return);
  EXPECT_FALSE(popup().isVisible());
  const MeshItem* mesh = bench().active_mesh();
  ASSERT_TRUE(mesh);
  const std::vector<PresetLabel> labels = offered_labels(scene());
  const PresetLabel* kidney = find_label(labels, "Left kidney");
  EXPECT_EQ(mesh->name, "Left kidney");
  EXPECT_EQ(mesh->label, 3);
  EXPECT_EQ(mesh->colour, kidney->colour);
  EXPECT_EQ(mesh->code, kidney->code);
  EXPECT_EQ(undos(), before + 1) << "name, colour, label and code are one unit of undo";
  EXPECT_TRUE(in_views());
  press(Qt::Key_2);  // keys act on the views again
  EXPECT_EQ(bench().view.tool, Tool::ZoomPan);
  window_->actions()[Act::Undo]->trigger();
  EXPECT_EQ(bench().active_mesh()->name, "mesh 1");
  EXPECT_TRUE(bench().active_mesh()->code.empty());
  EXPECT_NE(bench().active_mesh()->label, 3) << "3 is reserved for the left kidney";
}

TEST_F(NamesTest, EscAndAClickElsewhereKeepTheName) {
  ASSERT_TRUE(choose_label_preset(bench(), "abdomen"));
  place_seed();
  type("sp");
  const std::size_t before = undos();
  press(Qt::Key_Escape);
  EXPECT_FALSE(popup().isVisible());
  EXPECT_FALSE(popup().line().list().isVisible());
  EXPECT_EQ(bench().active_mesh()->name, "mesh 1");
  EXPECT_TRUE(in_views());
  press(Qt::Key_N);
  ASSERT_TRUE(popup().isVisible());
  EXPECT_EQ(popup().line().text(), "") << "the key itself is not typed";
  QTest::mouseClick(&axial(), Qt::LeftButton, {}, QPoint(30, axial().height() - 30));
  EXPECT_FALSE(popup().isVisible());
  EXPECT_EQ(bench().active_mesh()->name, "mesh 1");
  EXPECT_EQ(undos(), before);
}

TEST_F(NamesTest, WithoutAPresetASeedAsksForNothingAndKeyNDoes) {
  place_seed();
  EXPECT_FALSE(popup().isVisible());
  const int label = bench().active_mesh()->label;
  press(Qt::Key_N);
  ASSERT_TRUE(popup().isVisible());
  type("hippo");
  press(Qt::Key_Down);
  press(Qt::Key_Return);
  EXPECT_EQ(bench().active_mesh()->name, "Right hippocampus") << "the second suggestion";
  EXPECT_EQ(bench().active_mesh()->code.modifier.meaning, "Right");
  EXPECT_EQ(bench().active_mesh()->label, label) << "labels follow names only with a preset";
}

TEST_F(NamesTest, TheTypedTextCanBeKept) {
  ASSERT_TRUE(choose_label_preset(bench(), "abdomen"));
  place_seed();
  type("li");
  press(Qt::Key_Up);  // the last row
  press(Qt::Key_Return);
  EXPECT_EQ(bench().active_mesh()->name, "li");
  EXPECT_TRUE(bench().active_mesh()->code.empty());
  press(Qt::Key_N);
  type("lesion B");
  press(Qt::Key_Return);
  EXPECT_EQ(bench().active_mesh()->name, "lesion B");
  EXPECT_FALSE(popup().isVisible());
}

TEST_F(NamesTest, TheNameOnTheCardIsCompleted) {
  ASSERT_TRUE(choose_label_preset(bench(), "spine"));
  NameLine& name = card_name();
  QTest::mouseClick(&name, Qt::LeftButton);
  name.selectAll();
  const std::size_t before = undos();
  type("l3");
  EXPECT_TRUE(name.list().isVisible());
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) window_->grab().save(QString(folder) + "/name_card.png");
  press(Qt::Key_Return);
  EXPECT_FALSE(name.list().isVisible());
  EXPECT_EQ(scene().meshes[0].name, "L3 vertebra");
  EXPECT_EQ(scene().meshes[0].label, 22);
  EXPECT_EQ(scene().meshes[0].code.type.value, "36470004");
  EXPECT_EQ(undos(), before + 1);
  EXPECT_TRUE(name.toolTip().contains("36470004"));
  // A mouse press on a suggestion accepts it.
  QTest::mouseClick(&name, Qt::LeftButton);
  name.selectAll();
  type("sa");
  ASSERT_TRUE(name.list().isVisible());
  QTest::mouseClick(name.list().viewport(), Qt::LeftButton, {},
                    name.list().visualItemRect(name.list().item(0)).center());
  EXPECT_EQ(scene().meshes[0].name, "Sacrum");
  EXPECT_FALSE(name.list().isVisible());
}

TEST_F(NamesTest, AStructureChosenTwiceIsNumbered) {
  ASSERT_TRUE(choose_label_preset(bench(), "abdomen"));
  for (int n = 0; n < 2; ++n) {
    place_seed();
    type("tu");
    press(Qt::Key_Return);
  }
  ASSERT_EQ(scene().meshes.size(), 3u);
  EXPECT_EQ(scene().meshes[1].name, "Tumour");
  EXPECT_EQ(scene().meshes[1].label, 34);
  EXPECT_EQ(scene().meshes[2].name, "Tumour 2");
  EXPECT_EQ(scene().meshes[2].code, scene().meshes[1].code);
  EXPECT_NE(scene().meshes[2].label, 34);
  EXPECT_FALSE(scene().meshes[2].colour == scene().meshes[1].colour);
}

TEST_F(NamesTest, TheMenuListsPresetsOfTheProgramAndOfTheUser) {
  auto* menu = window_->findChild<LabelPresetMenu*>("label_presets");
  ASSERT_TRUE(menu);
  const QByteArray config = qgetenv("XDG_CONFIG_HOME");
  qputenv("XDG_CONFIG_HOME", folder_.filePath("config").toUtf8());
  QDir().mkpath(LabelPresetMenu::folder());
  QFile own(LabelPresetMenu::folder() + "/knees.json");
  ASSERT_TRUE(own.open(QIODevice::WriteOnly));
  own.write(
      R"({"simplexseg_labels": 1, "title": "Knees", "labels": [{"name": "Left knee", "number": 9, "colour": "#ff0000"}]})");
  own.close();
  emit menu->aboutToShow();
  const auto entry = [&](const QString& title) -> QAction* {
    for (QAction* action : menu->actions())
      if (action->text() == title) return action;
    return nullptr;
  };
  for (const char* title : {"None", "Abdomen", "Spine", "Brain", "Heart", "Head and neck", "knees"})
    EXPECT_TRUE(entry(title)) << title;
  EXPECT_TRUE(entry("None")->isChecked());
  entry("knees")->trigger();
  emit menu->aboutToShow();
  EXPECT_TRUE(entry("knees")->isChecked());
  EXPECT_EQ(scene().labels.by_name.at("Left knee"), 9);
  place_seed();
  type("lk");
  press(Qt::Key_Return);
  EXPECT_EQ(bench().active_mesh()->name, "Left knee") << "the user's preset before those of the program";
  EXPECT_EQ(bench().active_mesh()->label, 9);
  own.remove();
  EXPECT_EQ(offered_labels(scene()).front().name, "Left knee") << "without the file, from the scene";
  EXPECT_FALSE(choose_label_preset(bench(), "/nowhere/own.json"));
  EXPECT_TRUE(window_->findChild<MessageBar*>()->isVisible());
  entry("None")->trigger();
  EXPECT_EQ(scene().labels.preset, "");
  config.isEmpty() ? qunsetenv("XDG_CONFIG_HOME") : qputenv("XDG_CONFIG_HOME", config);
}

}  // namespace
}  // namespace simplexseg
