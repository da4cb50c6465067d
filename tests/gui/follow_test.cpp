// SPDX-License-Identifier: Apache-2.0
// Follow-up in the window: next study, table, time points.
#include <QComboBox>
#include <QDialogButtonBox>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTableWidget>
#include <QTest>

#include "gui/panels/follow_panel.h"
#include "gui/window/file_actions.h"
#include "gui/window/follow_actions.h"
#include "gui/window/follow_dialog.h"
#include "gui/window/time_point_dialog.h"
#include "gui/workbench/background_job.h"
#include "io/scene/scene_io.h"
#include "mesh/mesh_geometry.h"
#include "support/follow_images.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

const Eigen::Vector3d kShift(2, -2, 1);

class FollowTest : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped()) return;
    QObject::connect(&bench(), &Workbench::message, &bench(),
                     [this](Severity, const QString& text) { messages_.append(text); });
    write_volume(path("next.nii"), lesion_image(kShift, 1.1 * kLesionRadius));
  }
  std::filesystem::path path(const QString& name) const { return folder_.filePath(name).toStdString(); }
  /// Opens an image, segments the lesion with two marks, and saves the scene as first.json.
  void segment(const QString& image) {
    bench().view.show_meshes = false;
    bench().mark_saved();
    window_->files().open(folder_.filePath(image));
    ASSERT_TRUE(wait_for_job());
    if (auto* const dialog = window_->findChild<QDialog*>("volume_dialog")) {
      dialog->accept();  // volume 1
      ASSERT_TRUE(wait_for_job());
    }
    AddMesh add;
    add.name = "lesion", add.seed = {kLesionCentre, 8};
    ItemId mesh = 0;
    ASSERT_TRUE(bench().apply(add, &mesh));
    for (const auto& [at, kind] :
         {std::pair{Eigen::Vector3d(64, 38, 42), MarkKind::Outside}, {Eigen::Vector3d(46, 38, 42), MarkKind::Inside}}) {
      AddPoint point{mesh, at};
      point.kind = kind, point.radius_mm = 3;
      ASSERT_TRUE(bench().apply(point));
    }
    for (int n = 0; n < 60; ++n)
      if (bench().advance_steps(50, true).at_rest) break;
    bench().pause();
    ASSERT_TRUE(window_->files().save_scene_to(folder_.filePath("first.json")));
  }
  template <class T>
  T& control(const char* name) {
    auto* const found = window_->findChild<T*>(name);
    EXPECT_NE(found, nullptr) << name;
    return *found;
  }
  FollowDialog& ask(Act act) {
    window_->actions()[act]->trigger();
    return control<FollowDialog>("follow_dialog");
  }
  void set_text(const char* name, const QString& text) { control<QLineEdit>(name).setText(text); }
  void set_registration(const char* text) {
    auto& box = control<QComboBox>("follow_registration");
    box.setCurrentIndex(box.findText(text, Qt::MatchStartsWith));
  }
  static void confirm(const FollowDialog& dialog) {
    QTest::mouseClick(dialog.findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok), Qt::LeftButton);
  }
  QTableWidget& table() { return control<QTableWidget>("follow_table"); }
  QStringList messages_;
};

TEST_F(FollowTest, CarriesTheSceneOverToTheNextStudyAndComparesThem) {
  write_volume(path("first.nii"), lesion_image(Eigen::Vector3d::Zero(), kLesionRadius));
  segment("first.nii");
  const double before_ml = measure(scene().meshes[0].mesh).volume_mm3 / 1000;
  FollowDialog& dialog = ask(Act::FollowStudy);
  set_text("follow_image", folder_.filePath("next.nii"));
  set_registration("none");
  const QString output = control<QLineEdit>("follow_output").text();
  EXPECT_TRUE(output.endsWith("-follow-up.simplexseg.json")) << output.toStdString();
  confirm(dialog);
  ASSERT_TRUE(wait_for_job());
  EXPECT_TRUE(messages_.back().contains("Carried over 1 segmentation and")) << messages_.join('|').toStdString();
  EXPECT_EQ(window_->files().scene_path(), output);
  EXPECT_TRUE(scene().volume_path.ends_with("next.nii"));
  EXPECT_TRUE(bench().running());
  // The earlier study is a layer, which M shows.
  ASSERT_EQ(scene().layers.size(), 1u);
  EXPECT_EQ(scene().layers[0].name, "Earlier: first");
  EXPECT_NE(bench().layer_images().image_of(scene().layers[0]), nullptr);
  EXPECT_FALSE(bench().view.show_layers);
  // The mesh follows the lesion, and the panel shows its growth.
  for (int n = 0; n < 60; ++n)
    if (bench().advance_steps(50, true).at_rest) break;
  const SurfaceMeasures now = measure(scene().meshes[0].mesh);
  EXPECT_LT((now.centroid_mm - kLesionCentre - kShift).norm(), 1);
  EXPECT_NEAR(now.volume_mm3 / 1000 / before_ml, std::pow(1.1, 3), 0.12);
  EXPECT_TRUE(window_->findChild<FollowPanel*>()->isVisible());
  const double now_ml = now.volume_mm3 / 1000;
  const auto shown_ml = [&](int row) { return table().item(row, 0)->text().section(' ', 0, 0).toDouble(); };
  EXPECT_TRUE(wait_until([&] { return table().columnCount() == 1 && std::abs(shown_ml(1) - now_ml) < 0.02; }))
      << now_ml;
  EXPECT_EQ(table().horizontalHeaderItem(0)->text(), "lesion");
  EXPECT_NEAR(shown_ml(0), before_ml, 0.02);
  EXPECT_TRUE(table().item(2, 0)->text().startsWith('+'));
  // Saved and opened again, the scene has the same comparison.
  ASSERT_TRUE(window_->files().save_scene());
  messages_.clear();
  window_->files().open(output);
  ASSERT_TRUE(wait_for_job());
  EXPECT_TRUE(messages_.isEmpty()) << messages_.join('|').toStdString();
  ASSERT_TRUE(scene().meshes[0].start);
  EXPECT_NEAR(scene().meshes[0].start->earlier.volume_ml, before_ml, 1e-6);
  // A study without earlier one has no such panel.
  window_->files().open(folder_.filePath("first.json"));
  ASSERT_TRUE(wait_for_job());
  EXPECT_FALSE(window_->findChild<FollowPanel*>()->isVisible());
}

TEST_F(FollowTest, RefusesToReplaceTheOpenStudyAndMissingImages) {
  write_volume(path("first.nii"), lesion_image(Eigen::Vector3d::Zero(), kLesionRadius));
  EXPECT_FALSE(window_->actions()[Act::FollowStudy]->isEnabled()) << "there is no segmentation";
  segment("first.nii");
  FollowDialog& dialog = ask(Act::FollowStudy);
  const auto message = [&] { return control<QLabel>("follow_message").text().toStdString(); };
  confirm(dialog);
  EXPECT_NE(message().find("choose a file"), std::string::npos) << message();
  set_text("follow_image", folder_.filePath("missing.nii"));
  confirm(dialog);
  EXPECT_NE(message().find("file not found"), std::string::npos) << message();
  set_text("follow_image", folder_.filePath("next.nii"));
  set_text("follow_output", folder_.filePath("first.json"));
  confirm(dialog);
  EXPECT_NE(message().find("first.json"), std::string::npos) << message();
  EXPECT_TRUE(dialog.isVisible());
  EXPECT_FALSE(window_->job().busy());
  dialog.reject();
}

TEST_F(FollowTest, ACancelledCarryOverChangesNothing) {
  write_volume(path("first.nii"), lesion_image(Eigen::Vector3d::Zero(), kLesionRadius));
  segment("first.nii");
  FollowDialog::Choice choice;
  choice.image.path = path("next.nii").string();
  choice.output = path("cancelled.json");
  window_->follow().carry_over(choice);
  ASSERT_TRUE(window_->job().is_cancellable());
  window_->job().cancel();
  QTest::qWait(2000);  // enough for the work without a cancellation
  EXPECT_TRUE(scene().volume_path.ends_with("first.nii"));
  EXPECT_FALSE(QFile::exists(folder_.filePath("cancelled.json")));
}

TEST_F(FollowTest, FollowsTimePointsAndOpensTheirScenesFromTheTable) {
  std::vector<Volume> volumes;
  for (const double factor : {1.0, 1.05, 1.1})
    volumes.push_back(lesion_image(Eigen::Vector3d::Zero(), factor * kLesionRadius));
  write_series(path("series.nii"), volumes, 40);
  segment("series.nii");
  FollowDialog& dialog = ask(Act::FollowTimePoints);
  set_registration("none");
  EXPECT_TRUE(control<QLineEdit>("follow_image").text().endsWith("series.nii"));
  set_text("follow_output", folder_.filePath("points"));
  confirm(dialog);
  ASSERT_TRUE(wait_until([&] { return window_->findChild<TimePointDialog*>() != nullptr; }));
  auto& points = control<QTableWidget>("time_point_table");
  ASSERT_EQ(points.rowCount(), 3);
  EXPECT_EQ(points.item(2, 1)->text(), "0.08");
  const double first = points.item(0, 2)->text().section(' ', 0, 0).toDouble(),
               last = points.item(2, 2)->text().section(' ', 0, 0).toDouble();
  EXPECT_NEAR(last / first, std::pow(1.1, 3), 0.1);
  EXPECT_TRUE(control<QLabel>("time_point_summary").text().contains("smallest"));
  for (const char* name : {"points/first-curve.csv", "points/first-curve.png", "points/first-003.json"})
    EXPECT_TRUE(QFile::exists(folder_.filePath(name))) << name;
  points.selectRow(2);
  QTest::mouseClick(&control<QPushButton>("open_time_point"), Qt::LeftButton);
  ASSERT_TRUE(wait_for_job());
  EXPECT_EQ(scene().volume_number, 3);
  EXPECT_NEAR(measure(scene().meshes[0].mesh).volume_mm3 / 1000, last, 0.01 * last);
}

}  // namespace
}  // namespace simplexseg
