// SPDX-License-Identifier: Apache-2.0
// Menu of the model of the active segmentation.
#include "gui/window/model_menu.h"

#include <QAction>
#include <QInputDialog>
#include <QKeyEvent>
#include <QLabel>
#include <QSlider>
#include <QTimer>
#include <QToolButton>
#include <fstream>

#include "io/model/model_file.h"
#include "model/model_training.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class ModelMenuTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    checksum_ = write_sphere_model(path("sphere.model"));
  }
  QString path(const QString& name) const { return folder_.filePath(name); }
  ModelMenu& menu() { return *window_->findChild<ModelMenu*>(); }
  QAction& entry(const char* name) { return *menu().findChild<QAction*>(name); }
  const MeshItem& item() { return scene().meshes.at(0); }

  std::string checksum_;
};

TEST_F(ModelMenuTest, SetsAndRemovesTheModelAsActions) {
  ASSERT_TRUE(entry("choose_model").isEnabled());
  EXPECT_FALSE(entry("remove_model").isEnabled());
  menu().choose(path("sphere.model"));
  ASSERT_TRUE(item().model);
  EXPECT_EQ(item().model->checksum, checksum_);
  EXPECT_TRUE(entry("choose_model").text().contains("sphere.model")) << entry("choose_model").text().toStdString();
  const QLabel& card = *window_->findChild<QLabel*>("card_prior");
  EXPECT_TRUE(card.isVisible());
  EXPECT_TRUE(card.text().contains("sphere.model")) << card.text().toStdString();
  EXPECT_TRUE(card.toolTip().contains("1 case")) << card.toolTip().toStdString();
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) window_->grab().save(QString(folder) + "/card.png");
  entry("remove_model").trigger();
  EXPECT_FALSE(item().model);
  EXPECT_FALSE(card.isVisible());
  press(Act::Undo);
  EXPECT_TRUE(item().model);
  press(Act::Undo);
  EXPECT_FALSE(item().model);
}

TEST_F(ModelMenuTest, OfADamagedFileShowsOneMessageAndChangesNothing) {
  std::ofstream(path("bad.model").toStdString()) << "no model";
  QStringList messages;
  QObject::connect(&bench(), &Workbench::message, &bench(),
                   [&](Severity, const QString& text) { messages.append(text); });
  menu().choose(path("bad.model"));
  ASSERT_EQ(messages.size(), 1);
  EXPECT_TRUE(messages[0].contains("bad.model")) << messages[0].toStdString();
  EXPECT_FALSE(item().model);
}

TEST_F(ModelMenuTest, IsDisabledWithAReasonForALockedSegmentation) {
  EditMesh lock{};
  lock.mesh = item().id;
  lock.locked = true;
  bench().apply(lock);
  EXPECT_FALSE(entry("choose_model").isEnabled());
  EXPECT_FALSE(entry("choose_model").toolTip().isEmpty());
}

TEST_F(ModelMenuTest, ShowsSlidersOfModesThatChangeTheStartShape) {
  const QWidget& sliders = *window_->findChild<QWidget*>("mode_sliders");
  EXPECT_FALSE(sliders.isVisible());
  menu().choose(path("sphere.model"));
  ASSERT_TRUE(sliders.isVisible());
  auto& first = *window_->findChild<QSlider*>("mode_1");
  auto& sphere = *window_->findChild<QToolButton*>("start_from_sphere");
  EXPECT_FALSE(sphere.isEnabled());
  const std::vector<Eigen::Vector3f> before = item().mesh.positions;
  const QPointF middle(first.width() / 2.0, first.height() / 2.0);
  drag(first, {middle, middle + QPointF(first.width() / 8.0, 0), middle + QPointF(first.width() / 4.0, 0)});
  ASSERT_EQ(item().start_modes.size(), 1u);
  EXPECT_GT(item().start_modes[0], 0.3f);
  const std::vector<Eigen::Vector3f> longer = item().mesh.positions;
  EXPECT_NE(longer, before);
  if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) window_->grab().save(QString(folder) + "/modes.png");
  first.setFocus();
  QKeyEvent key(QEvent::KeyPress, Qt::Key_Left, Qt::NoModifier);
  QApplication::sendEvent(&first, &key);
  EXPECT_NE(item().mesh.positions, longer);
  press(Act::Undo);
  EXPECT_EQ(item().mesh.positions, longer);
  press(Act::Undo);  // the whole drag
  EXPECT_EQ(item().mesh.positions, before);
  EXPECT_EQ(first.value(), 0);
  press(Act::Redo);
  EXPECT_EQ(item().mesh.positions, longer);
  EXPECT_GT(first.value(), 0);
  EXPECT_TRUE(sphere.isEnabled());
  drag(sphere, {QPointF(5, 5), QPointF(5, 5)});
  EXPECT_TRUE(item().start_modes.empty());
  EXPECT_EQ(first.value(), 0);
}

class SeveralOrgansTest : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped()) return;
    const PhantomSettings size{.size = 48};
    const Phantom phantom = make_phantom("two-spheres", size);
    Scene scene;
    scene.simulation = default_simulation_parameters();
    MeshItem item;
    item.name = "right";
    item.seed = {{9.5, -0.5, -0.5}, 7};
    item.parameters = scene.forces;
    scene.meshes.push_back(item);
    ModelFile file;
    for (const double label : {1.0, 2.0}) {
      const std::vector<ModelCase> cases{{"pair", phantom.image, mask_of(phantom.labels, label), {}}};
      const TrainingSettings settings{.vertices = 200, .modes = 5};
      file.organs.push_back(train_model(register_cases(cases, settings, run_serially()), settings, run_serially()));
      file.organs.back().name = label == 1 ? "left" : "right";
    }
    file.relations = train_relations(file.organs);
    write_model(folder_.filePath("pair.model").toStdString(), file);
    bench().open(std::move(scene), phantom.image);
    bench().pause();
    QApplication::processEvents();
  }
};

TEST_F(SeveralOrgansTest, AskForTheOrganAndFindTheOthersFromIt) {
  ModelMenu& menu = *window_->findChild<ModelMenu*>();
  QAction& start = *menu.findChild<QAction*>("start_organs");
  EXPECT_FALSE(start.isEnabled());
  QString offered;
  QTimer::singleShot(0, [&] {
    auto* const dialog = qobject_cast<QInputDialog*>(QApplication::activeModalWidget());
    if (!dialog) return;
    offered = dialog->textValue();
    dialog->accept();
  });
  menu.choose(folder_.filePath("pair.model"));
  EXPECT_EQ(offered, "right") << "the organ of the name of the segmentation";
  ASSERT_TRUE(scene().meshes[0].model);
  EXPECT_EQ(scene().meshes[0].model->number, 1);
  ASSERT_TRUE(start.isEnabled());
  bool done = false;
  QObject::connect(&menu, &ModelMenu::organs_started, window_.get(), [&] { done = true; });
  start.trigger();
  ASSERT_TRUE(wait_until([&] { return done; }));
  bench().pause();
  ASSERT_EQ(scene().meshes.size(), 2u);
  const MeshItem& found = scene().meshes[1];
  EXPECT_EQ(found.name, "left");
  EXPECT_EQ(found.model->number, 0);
  EXPECT_LT((found.seed.centre_mm - Eigen::Vector3d(-9.5, -0.5, -0.5)).norm(), 2.5);
  EXPECT_EQ(bench().view.active_mesh, scene().meshes[0].id);
  // Nothing is left to find.
  QStringList messages;
  QObject::connect(&bench(), &Workbench::message, &bench(),
                   [&](Severity, const QString& text) { messages.append(text); });
  done = false;
  start.trigger();
  ASSERT_TRUE(wait_until([&] { return done; }));
  EXPECT_EQ(scene().meshes.size(), 2u);
  EXPECT_EQ(messages.size(), 1);
  window_->actions()[Act::Undo]->trigger();
  EXPECT_EQ(scene().meshes.size(), 1u);
}

}  // namespace
}  // namespace simplexseg
