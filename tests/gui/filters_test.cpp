// SPDX-License-Identifier: Apache-2.0
// Filters of layers and of the volume, and landmarks of a registration, in the window.
#include <QComboBox>
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QListWidget>
#include <QPushButton>
#include <QStandardItemModel>
#include <QTest>
#include <QTreeWidget>

#include "core/error.h"
#include "gui/panels/layer_panel.h"
#include "gui/window/file_actions.h"
#include "gui/window/filter_actions.h"
#include "gui/window/filter_dialog.h"
#include "gui/window/layer_actions.h"
#include "gui/window/register_dialog.h"
#include "gui/workbench/background_job.h"
#include "io/platform/worker_program.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class FiltersTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    QObject::connect(&bench(), &Workbench::message, &bench(),
                     [this](Severity, const QString& text) { messages_.append(text); });
    bench().view.show_meshes = false;
    write_volume(path("image.nii"), bench().session().volume());
    window_->files().open(QString::fromStdString(path("image.nii")));
    ASSERT_TRUE(wait_for_job());
    original_ = checksum_of(bench().session().volume());
    try {
      path_of_program(kRegisterProgram);
    } catch (const Error&) {
      GTEST_SKIP() << "built without ITK";
    }
  }
  std::string path(const QString& name) const { return folder_.filePath(name).toStdString(); }
  void add_layer() {
    window_->layers().add(QString::fromStdString(path("image.nii")));
    ASSERT_TRUE(wait_for_job());
    ASSERT_EQ(scene().layers.size(), 1u);
  }
  const LayerItem& layer() { return scene().layers.at(0); }
  template <class T>
  T& control(const char* name) {
    return *window_->findChild<T*>(name);
  }
  /// Opens the dialog, chooses a filter and applies it.
  void apply_filter(Act act, const char* title) {
    press(act);
    auto& dialog = control<FilterDialog>("filter_dialog");
    auto& kind = control<QComboBox>("filter_kind");
    kind.setCurrentIndex(kind.findText(title));
    QTest::mouseClick(dialog.findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok), Qt::LeftButton);
    ASSERT_TRUE(wait_for_job());
    ASSERT_TRUE(wait_until([&] { return !window_->findChild<FilterDialog*>(); }));
  }
  std::string checksum() { return checksum_of(bench().session().volume()); }

  QStringList messages_;
  std::string original_;
};

TEST_F(FiltersTest, TheVolumeIsFilteredAndTheOriginalStays) {
  const QImage before = axial().grabFramebuffer();
  apply_filter(Act::FilterVolume, "Median");
  const std::string filtered = checksum();
  EXPECT_NE(filtered, original_);
  EXPECT_EQ(scene().volume_preprocessing.checksum, filtered);
  EXPECT_EQ(scene().volume_checksum, original_);
  EXPECT_NE(axial().grabFramebuffer(), before);
  EXPECT_TRUE(messages_.back().contains("Median (radius 1)")) << messages_.back().toStdString();
  EXPECT_TRUE(window_->findChild<LayerPanel*>()->isVisible());
  EXPECT_TRUE(control<QLabel>("volume_filters").text().contains("Median (radius 1)"));
  press(Act::Undo);
  EXPECT_EQ(checksum(), original_);
  EXPECT_EQ(axial().grabFramebuffer(), before);
  EXPECT_FALSE(window_->findChild<LayerPanel*>()->isVisible());
  press(Act::Redo);
  EXPECT_EQ(checksum(), filtered);
  // The saved scene has the same values when it is opened, and can still undo.
  write_scene(path("scene.json"), bench().scene_to_save(), bench().session().history());
  bench().mark_saved();
  messages_.clear();
  window_->files().open(QString::fromStdString(path("scene.json")));
  ASSERT_TRUE(wait_for_job());
  EXPECT_TRUE(messages_.isEmpty()) << messages_.join('|').toStdString();
  EXPECT_EQ(checksum(), filtered);
  press(Act::Undo);
  EXPECT_EQ(checksum(), original_);
}

TEST_F(FiltersTest, TheVolumeKeepsItsGrid) {
  press(Act::FilterVolume);
  auto& kind = control<QComboBox>("filter_kind");
  const auto* const model = qobject_cast<QStandardItemModel*>(kind.model());
  EXPECT_FALSE(model->item(kind.findText("Isotropic resampling"))->isEnabled());
  EXPECT_TRUE(model->item(kind.findText("Median"))->isEnabled());
  control<FilterDialog>("filter_dialog").reject();
  window_->filters().filter_volume({{FilterKind::Isotropic, {0.5}}});
  ASSERT_TRUE(wait_for_job());
  EXPECT_EQ(checksum(), original_);
}

TEST_F(FiltersTest, LayersHaveAListOfFilters) {
  add_layer();
  const std::shared_ptr<const Volume> original = bench().layer_images().image_of(layer());
  apply_filter(Act::FilterLayer, "Median");
  apply_filter(Act::FilterLayer, "Isotropic resampling");
  EXPECT_EQ(key_of(layer().preprocessing.filters), "median(radius=1);isotropic(spacing=0)");
  const std::shared_ptr<const Volume> filtered = bench().layer_images().image_of(layer());
  ASSERT_NE(filtered, nullptr);
  EXPECT_EQ(layer().preprocessing.checksum, checksum_of(*filtered));
  EXPECT_EQ(control<QLabel>("layer_filters").text(),
            "Filters: Median (radius 1), then Isotropic resampling (spacing 0)");
  EXPECT_EQ(checksum(), original_);  // of the volume
  press(Act::FilterLayer);
  EXPECT_EQ(control<QListWidget>("filter_list").count(), 2);
  QTest::mouseClick(&control<QPushButton>("remove_filter"), Qt::LeftButton);
  ASSERT_TRUE(wait_for_job());
  EXPECT_EQ(key_of(layer().preprocessing.filters), "median(radius=1)");
  press(Act::Undo);
  EXPECT_EQ(bench().layer_images().image_of(layer()), filtered);
  for (int n = 0; n < 2; ++n) press(Act::Undo);
  EXPECT_EQ(bench().layer_images().image_of(layer()), original);
  for (int n = 0; n < 2; ++n) press(Act::Redo);
  write_scene(path("scene.json"), bench().scene_to_save(), bench().session().history());
  bench().mark_saved();
  messages_.clear();
  window_->files().open(QString::fromStdString(path("scene.json")));
  ASSERT_TRUE(wait_for_job());
  EXPECT_TRUE(messages_.isEmpty()) << messages_.join('|').toStdString();
  EXPECT_EQ(checksum_of(*bench().layer_images().image_of(layer())), checksum_of(*filtered));
}

TEST_F(FiltersTest, ParametersAreThoseOfTheFilter) {
  add_layer();
  press(Act::FilterLayer);
  auto& dialog = control<FilterDialog>("filter_dialog");
  auto& kind = control<QComboBox>("filter_kind");
  EXPECT_EQ(kind.count(), 4);  // uptake values are no choice
  auto* const shrink = dialog.findChild<QDoubleSpinBox*>("filter_shrink");
  ASSERT_NE(shrink, nullptr);
  EXPECT_EQ(shrink->value(), 4);
  EXPECT_EQ(shrink->maximum(), 8);
  kind.setCurrentIndex(kind.findText("Anisotropic diffusion"));
  auto* const conductance = dialog.findChild<QDoubleSpinBox*>("filter_conductance");
  ASSERT_NE(conductance, nullptr);
  EXPECT_EQ(dialog.findChild<QDoubleSpinBox*>("filter_shrink"), nullptr);
  conductance->setValue(1.5);
  dialog.findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok)->click();
  ASSERT_TRUE(wait_for_job());
  EXPECT_EQ(key_of(layer().preprocessing.filters), "diffusion(iterations=5,conductance=1.5)");
}

TEST_F(FiltersTest, ACancelledFilterChangesNothing) {
  add_layer();
  window_->filters().filter_layer(layer().id, {{FilterKind::BiasField, {1, 6, 500}}});
  EXPECT_TRUE(window_->job().is_cancellable());
  window_->job().cancel();
  window_->filters().filter_volume({{FilterKind::BiasField, {1, 6, 500}}});
  EXPECT_TRUE(window_->job().is_cancellable());
  window_->job().cancel();
  EXPECT_FALSE(window_->job().busy());
  EXPECT_TRUE(layer().preprocessing.filters.empty() && scene().volume_preprocessing.filters.empty());
  EXPECT_EQ(checksum(), original_);
}

TEST_F(FiltersTest, LandmarksStartARegistration) {
  // The layer is the volume, moved by 9 mm: pairs of clicks are 9 mm apart.
  const Volume image = bench().session().volume();
  VolumeGeometry grid = image.geometry();
  grid.origin_mm.x() -= 9;
  Volume moved(grid, image.type());
  std::memcpy(moved.data(), image.data(), image.bytes());
  write_volume(path("moved.nii"), moved);
  window_->layers().add(QString::fromStdString(path("moved.nii")));
  ASSERT_TRUE(wait_for_job());
  press(Act::RegisterLayer);
  auto& dialog = control<RegisterDialog>("register_dialog");
  EXPECT_FALSE(dialog.isModal());
  auto& start = control<QComboBox>("register_start");
  const auto is_offered = [&] {
    return qobject_cast<QStandardItemModel*>(start.model())->item(start.count() - 1)->isEnabled();
  };
  EXPECT_FALSE(is_offered());
  const Eigen::Vector3d crosshair = bench().view.crosshair_mm;
  QTest::mouseClick(&control<QPushButton>("place_landmarks"), Qt::LeftButton);
  EXPECT_EQ(bench().view.landmarks.next, LandmarkInput::Next::Volume);
  EXPECT_EQ(axial().cursor().shape(), Qt::CrossCursor);
  const std::pair<double, double> places[] = {{0, 10}, {10, -5}, {-8, -8}};
  for (const auto& [x, y] : places) {
    drag(axial(), pixel(x, y), pixel(x, y));
    EXPECT_EQ(bench().view.landmarks.next, LandmarkInput::Next::Layer);
    drag(axial(), pixel(x - 9, y), pixel(x - 9, y));
  }
  EXPECT_EQ(bench().view.crosshair_mm, crosshair);
  ASSERT_EQ(bench().view.landmarks.pairs.size(), 3u);
  EXPECT_TRUE(is_offered());
  auto& list = control<QTreeWidget>("landmark_list");
  ASSERT_EQ(list.topLevelItemCount(), 3);
  EXPECT_LT(list.topLevelItem(0)->text(3).toDouble(), 1.0);
  QTest::mouseClick(&control<QPushButton>("remove_landmark"), Qt::LeftButton);
  EXPECT_EQ(list.topLevelItemCount(), 2);
  EXPECT_FALSE(is_offered());
  drag(axial(), pixel(-8, -8), pixel(-8, -8));
  drag(axial(), pixel(-17, -8), pixel(-17, -8));
  ASSERT_TRUE(is_offered());
  EXPECT_EQ(dialog.landmarks().fixed.size(), 3u);
  const std::optional<Eigen::Affine3d> initial = dialog.settings().initial;
  ASSERT_TRUE(initial);
  EXPECT_NEAR((*initial * crosshair - crosshair).x(), -9, 1);
  dialog.accept();
  EXPECT_EQ(bench().view.landmarks.next, LandmarkInput::Next::None);
  EXPECT_TRUE(bench().view.landmarks.pairs.empty());
  ASSERT_TRUE(wait_for_job());
  EXPECT_TRUE(messages_.back().contains("Landmarks: residual")) << messages_.back().toStdString();
  EXPECT_NEAR((layer().transform.affine * crosshair - crosshair).x(), -9, 0.5);
}

TEST_F(FiltersTest, LandmarksOnALineAreRefused) {
  add_layer();
  press(Act::RegisterLayer);
  auto& dialog = control<RegisterDialog>("register_dialog");
  QTest::mouseClick(&control<QPushButton>("place_landmarks"), Qt::LeftButton);
  for (const double x : {-8.0, 0.0, 8.0}) {
    drag(axial(), pixel(x, 0), pixel(x, 0));
    drag(axial(), pixel(x, 0), pixel(x, 0));
  }
  EXPECT_THROW(dialog.settings(), Error);
  dialog.accept();
  EXPECT_TRUE(dialog.isVisible());
  EXPECT_TRUE(control<QLabel>("landmark_note").text().contains("line"));
  press(Act::RemoveLayer);  // closes the dialog
  EXPECT_FALSE(dialog.isVisible());
  EXPECT_TRUE(bench().view.landmarks.pairs.empty());
}

}  // namespace
}  // namespace simplexseg
