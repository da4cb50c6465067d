// SPDX-License-Identifier: Apache-2.0
// Menu of the model of the active segmentation.
#include "gui/window/model_menu.h"

#include <QAction>
#include <QLabel>
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
    const Volume& image = bench().session().volume();
    const Mask sphere = mask_of(make_phantom("sphere", {}).labels, 1.0);
    const std::vector<ModelCase> cases{{"sphere", image, sphere, {}}};
    const TrainingSettings settings{.vertices = 200, .modes = 5};
    ModelFile file;
    file.organs.push_back(train_model(register_cases(cases, settings, run_serially()), settings, run_serially()));
    write_model(path("sphere.model").toStdString(), file);
    checksum_ = file.checksum;
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
  const QLabel& card = *window_->findChild<QLabel*>("card_model");
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

}  // namespace
}  // namespace simplexseg
