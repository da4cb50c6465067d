// SPDX-License-Identifier: Apache-2.0
// Panel Convergence: plots, measurements and saved files.
#include "gui/panels/convergence_panel.h"

#include <QFile>
#include <QImage>
#include <QLabel>
#include <QPushButton>

#include "gui/look/theme.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class ConvergencePanelTest : public WindowTest {
 protected:
  QString path(const char* name) const { return folder_.filePath(name); }
  ConvergencePanel& panel() { return window_->panels().convergence(); }
  void show_panel() {
    window_->panels().show_panel("Convergence");
    ASSERT_TRUE(wait_until([&] { return panel().on_screen() && panel().width() > 100; }));
  }
  /// Writes a scene file of the phantom sphere with its labels, and a mesh with this reference.
  void write_scene_with_reference(const char* reference = "labels.nii.gz") {
    const Phantom phantom = make_phantom("sphere", {});
    write_volume(path("ball.nii.gz").toStdString(), phantom.image);
    write_labels(path("labels.nii.gz").toStdString(), phantom.labels);
    Scene scene;
    scene.simulation = default_simulation_parameters();
    scene.volume_path = path("ball.nii.gz").toStdString();
    MeshItem item;
    item.id = 1;
    item.name = "ball";
    item.seed = {phantom.image.geometry().centre_mm(), 10};
    item.parameters = default_force_parameters();
    item.mesh = make_sphere(item.seed.centre_mm, item.seed.radius_mm, 2);
    item.reference = Reference{reference, std::nullopt};
    scene.meshes.push_back(item);
    write_scene(path("scene.json").toStdString(), scene);
  }
  void open_scene() {
    window_->files().open(path("scene.json"));
    ASSERT_TRUE(wait_until([&] { return !scene().meshes.empty(); }));
  }
  std::string text_of(const QString& file_path) {
    QFile file(file_path);
    return file.open(QIODevice::ReadOnly) ? file.readAll().toStdString() : std::string();
  }
};

TEST_F(ConvergencePanelTest, ThePlotFollowsTheSteps) {
  open_phantom();
  show_panel();
  EXPECT_TRUE(panel().picture().isNull());  // a text, since nothing has run
  bench().advance_steps(30);
  ASSERT_TRUE(wait_until([&] { return !panel().picture().isNull(); }));
  const QImage first = panel().picture();
  EXPECT_GT(first.width(), 100);
  for (int n = 0; n < 5; ++n) bench().advance_steps(20);
  ASSERT_TRUE(wait_until([&] { return panel().picture() != first; }));
  const QImage by_time = panel().picture();
  panel().choose(TraceAxis::Steps);
  EXPECT_NE(panel().picture(), by_time);
}

TEST_F(ConvergencePanelTest, ThePlotFollowsTheTheme) {
  open_phantom();
  show_panel();
  bench().advance_steps(30);
  ASSERT_TRUE(wait_until([&] { return !panel().picture().isNull(); }));
  const auto background = [&] { return panel().picture().pixelColor(2, 2).lightness(); };
  for (const bool dark : {false, true}) {
    theme::apply(*qApp, dark);
    EXPECT_TRUE(wait_until([&] { return (background() < 128) == dark; })) << background();
  }
}

TEST_F(ConvergencePanelTest, TheResidualIsRecordedWhileHiddenWithoutReadingBack) {
  open_phantom();
  ASSERT_FALSE(panel().on_screen());
  for (int n = 0; n < 4; ++n) bench().advance_steps(10);
  ASSERT_EQ(panel().residuals().meshes().size(), 1u);
  const std::vector<TraceSample>& samples = panel().residuals().meshes()[0].samples;
  ASSERT_GE(samples.size(), 4u);
  EXPECT_GT(samples.back().residual_mm, 0);
  EXPECT_GT(samples.back().seconds, samples.front().seconds);
  EXPECT_TRUE(panel().picture().isNull());
  // The poses of the scene are outdated: they were not read back.
  const MeshItem& outdated = bench().session().scene_without_poses().meshes[0];
  const Eigen::Vector3f before = outdated.mesh.positions[0];
  EXPECT_NE(bench().session().scene().meshes[0].mesh.positions[0], before);
}

TEST_F(ConvergencePanelTest, ResetAndOpeningClearTheTrace) {
  open_phantom();
  for (int n = 0; n < 4; ++n) bench().advance_steps(10);
  ASSERT_FALSE(panel().residuals().meshes().empty());
  const double before = panel().residuals().meshes()[0].samples.back().seconds;
  bench().apply(ResetPose{0});
  EXPECT_TRUE(panel().residuals().meshes().empty());
  bench().advance_steps(1);
  ASSERT_FALSE(panel().residuals().meshes().empty());
  EXPECT_EQ(panel().residuals().meshes()[0].samples.size(), 1u);
  EXPECT_LT(panel().residuals().meshes()[0].samples[0].seconds, before);
  open_phantom();
  EXPECT_TRUE(panel().residuals().meshes().empty());
}

TEST_F(ConvergencePanelTest, TheSurfaceErrorAppearsWithAReferenceAndFalls) {
  write_scene_with_reference();
  open_scene();
  EXPECT_TRUE(bench().references().has(scene().meshes[0]));
  EXPECT_TRUE(window_->messages().text().isEmpty()) << window_->messages().text().toStdString();
  show_panel();
  EXPECT_TRUE(panel().errors().meshes().empty());  // not requested, not measured
  panel().choose(ConvergencePanel::Quantity::SurfaceError);
  ASSERT_TRUE(wait_until([&] { return panel().errors().has_errors(); }));
  const auto mean = [&] { return panel().errors().meshes()[0].samples.back().error->mean_mm; };
  const double at_first = mean();
  EXPECT_NEAR(at_first, 9.2, 0.7);  // a sphere of 10 mm in one of 0.3 x 64 mm
  bench().run();
  ASSERT_TRUE(wait_until([&] { return mean() < 0.3 * at_first; })) << mean();
  bench().pause();
  EXPECT_FALSE(panel().picture().isNull());
  window_->panels().show_panel("Forces");
  ASSERT_TRUE(wait_until([&] { return !panel().on_screen(); }));
  const std::size_t count = panel().errors().meshes()[0].samples.size();
  for (int n = 0; n < 10; ++n) bench().advance_steps(10);
  EXPECT_EQ(panel().errors().meshes()[0].samples.size(), count);
}

TEST_F(ConvergencePanelTest, WithoutAReferenceSavingIsDisabled) {
  open_phantom();
  show_panel();
  panel().choose(ConvergencePanel::Quantity::SurfaceError);
  for (int n = 0; n < 4; ++n) bench().advance_steps(10);
  EXPECT_TRUE(panel().errors().meshes().empty());
  EXPECT_TRUE(panel().picture().isNull());
  for (const QPushButton* button : panel().findChildren<QPushButton*>()) EXPECT_FALSE(button->isEnabled());
}

TEST_F(ConvergencePanelTest, AMissingReferenceIsAWarningAndTheSceneOpens) {
  write_scene_with_reference("no-such-labels.nii.gz");
  open_scene();
  EXPECT_TRUE(window_->messages().text().contains("no-such-labels")) << window_->messages().text().toStdString();
  EXPECT_FALSE(bench().references().has(scene().meshes[0]));
}

TEST_F(ConvergencePanelTest, PlotsAndTablesAreSaved) {
  open_phantom();
  show_panel();
  for (int n = 0; n < 6; ++n) bench().advance_steps(10);
  panel().save_to(path("plot.png"));
  EXPECT_GE(QImage(path("plot.png")).width(), 600);
  panel().save_to(path("plot.svg"));
  EXPECT_NE(text_of(path("plot.svg")).find("<svg"), std::string::npos);
  panel().save_to(path("plot.csv"));
  const std::string table = text_of(path("plot.csv"));
  EXPECT_EQ(table.find("mesh,seconds,steps"), 0u);
  EXPECT_NE(table.find("\nobject,"), std::string::npos);
  EXPECT_ANY_THROW(panel().save_to(path("plot.tiff")));
  EXPECT_ANY_THROW(panel().save_to(path("no/such/folder/plot.png")));
  panel().clear();
  EXPECT_TRUE(panel().residuals().meshes().empty());
  EXPECT_TRUE(panel().picture().isNull());
}

}  // namespace
}  // namespace simplexseg
