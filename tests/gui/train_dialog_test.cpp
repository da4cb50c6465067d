// SPDX-License-Identifier: Apache-2.0
// Training of a model from accepted cases.
#include "gui/window/train_dialog.h"

#include <QAction>
#include <QCheckBox>
#include <QFile>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QTest>
#include <fstream>

#include "gui/window/model_menu.h"
#include "io/model/model_file.h"
#include "io/volume/volume_io.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class TrainDialogTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    for (const int number : {1, 2}) {
      PhantomSettings settings;
      settings.size = 32, settings.noise_sigma = 20, settings.seed = static_cast<std::uint64_t>(number);
      const Phantom made = make_phantom("sphere", settings);
      write_volume(file(QString("image%1.nii.gz").arg(number)).toStdString(), made.image);
      write_volume(file(QString("truth%1.nii.gz").arg(number)).toStdString(), made.labels);
    }
    std::ofstream(file("cases.csv").toStdString())
        << "image,labels,label\nimage1.nii.gz,truth1.nii.gz,1\nimage2.nii.gz,truth2.nii.gz,1\n";
    window_->findChild<ModelMenu*>()->findChild<QAction*>("train_model")->trigger();
  }
  QString file(const QString& name) const { return folder_.filePath(name); }
  TrainDialog& dialog() { return *window_->findChild<TrainDialog*>("train_dialog"); }
  QPushButton& push_button(const char* name) { return *dialog().findChild<QPushButton*>(name); }
  QTableWidget& table() { return *dialog().findChild<QTableWidget*>("training_cases"); }
  QString shown() { return dialog().findChild<QLabel*>("training_message")->text(); }
  void click(const char* name) { QTest::mouseClick(&push_button(name), Qt::LeftButton); }
  bool trained() {
    for (int k = 0; k < 6; ++k)  // a minute at most
      if (wait_until([this] { return !dialog().busy(); })) return true;
    return false;
  }
  void picture(const char* name) {
    if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) dialog().grab().save(QString(folder) + "/" + name);
  }
};

TEST_F(TrainDialogTest, TrainsInTheBackgroundAndUsesTheModelAsAnAction) {
  EXPECT_TRUE(dialog().isVisible());
  EXPECT_FALSE(push_button("train").isEnabled());
  EXPECT_FALSE(push_button("train").toolTip().isEmpty());
  dialog().open_table(file("cases.csv"));
  ASSERT_EQ(table().rowCount(), 2);
  EXPECT_EQ(table().item(1, 0)->text(), "image2.nii.gz");
  EXPECT_TRUE(push_button("train").isEnabled());
  picture("train.png");
  dialog().train(file("ball.model"));
  EXPECT_TRUE(dialog().busy());
  EXPECT_FALSE(push_button("train").isEnabled());
  ASSERT_TRUE(trained());
  EXPECT_TRUE(shown().contains("2 cases")) << shown().toStdString();
  picture("trained.png");
  const ModelFile model = read_model(file("ball.model").toStdString());
  EXPECT_EQ(model.organs[0].cases.size(), 2u);
  ASSERT_TRUE(scene().meshes[0].model);
  EXPECT_EQ(scene().meshes[0].model->checksum, model.checksum);
  press(Act::Undo);
  EXPECT_FALSE(scene().meshes[0].model);
}

TEST_F(TrainDialogTest, AddsSelectedCasesToAModelWithoutUsingIt) {
  dialog().open_table(file("cases.csv"));
  dialog().findChild<QCheckBox*>("use_trained_model")->setChecked(false);
  table().selectRow(1);
  click("remove_cases");
  ASSERT_EQ(table().rowCount(), 1);
  dialog().train(file("one.model"));
  ASSERT_TRUE(trained());
  EXPECT_FALSE(scene().meshes[0].model);
  table().selectRow(0);
  click("remove_cases");
  dialog().add_case(file("image2.nii.gz"), file("truth2.nii.gz"), "1");
  dialog().set_base(file("one.model"));
  dialog().train(file("two.model"));
  ASSERT_TRUE(trained());
  const ModelFile two = read_model(file("two.model").toStdString());
  ASSERT_EQ(two.organs[0].cases.size(), 2u) << shown().toStdString();
  EXPECT_EQ(two.organs[0].cases[1].error_cases, 1);
}

TEST_F(TrainDialogTest, CancelsWithoutAFile) {
  dialog().open_table(file("cases.csv"));
  dialog().train(file("no.model"));
  click("cancel_training");
  EXPECT_FALSE(dialog().busy());
  EXPECT_TRUE(shown().contains("Cancelled"));
  EXPECT_TRUE(push_button("train").isEnabled());
  dialog().train(file("again.model"));  // while the cancelled one may still run
  ASSERT_TRUE(trained());
  EXPECT_TRUE(QFile::exists(file("again.model")));
  EXPECT_FALSE(QFile::exists(file("no.model")));
}

TEST_F(TrainDialogTest, ShowsWhyCasesCannotBeUsed) {
  dialog().open_table(file("none.csv"));
  EXPECT_TRUE(shown().contains("none.csv")) << shown().toStdString();
  EXPECT_EQ(table().rowCount(), 0);
  dialog().add_case(file("image1.nii.gz"), file("truth1.nii.gz"), "7");
  dialog().train(file("no.model"));
  ASSERT_TRUE(trained());
  EXPECT_TRUE(shown().contains("7")) << shown().toStdString();
  EXPECT_FALSE(QFile::exists(file("no.model")));
  table().item(0, 2)->setText("1");
  dialog().train(file("yes.model"));
  ASSERT_TRUE(trained());
  EXPECT_TRUE(QFile::exists(file("yes.model"))) << shown().toStdString();
}

TEST_F(TrainDialogTest, TakesTheActiveSegmentationOnceItIsAccepted) {
  EXPECT_FALSE(push_button("add_active_case").isEnabled());
  EXPECT_FALSE(push_button("add_active_case").toolTip().isEmpty());
  // A scene of a file, with a locked segmentation.
  Scene of_file = scene();
  of_file.volume_path = file("phantom.nii.gz").toStdString();
  of_file.meshes[0].locked = true;
  const Volume image = bench().session().volume();
  write_volume(of_file.volume_path, image);
  bench().open(of_file, image);
  ASSERT_TRUE(push_button("add_active_case").isEnabled()) << push_button("add_active_case").toolTip().toStdString();
  dialog().add_active(file("accepted.nii.gz"));
  ASSERT_EQ(table().rowCount(), 1) << shown().toStdString();
  const Volume labels = read_volume(file("accepted.nii.gz").toStdString());
  const Mask object = mask_of(labels, 1.0);
  const auto voxels = std::ranges::count(object.voxels, std::uint8_t{1});
  EXPECT_NEAR(static_cast<double>(voxels), 4.0 / 3 * M_PI * 12 * 12 * 12, 500);
  dialog().train(file("accepted.model"));
  ASSERT_TRUE(trained());
  EXPECT_EQ(read_model(file("accepted.model").toStdString()).organs[0].cases.size(), 1u) << shown().toStdString();
}

}  // namespace
}  // namespace simplexseg
