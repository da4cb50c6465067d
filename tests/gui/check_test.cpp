// SPDX-License-Identifier: Apache-2.0
// Panel Check: comparison with a reference, colours of surfaces, worst places; meshes from labels and files.
#include <QAction>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QFile>
#include <QLabel>
#include <QPushButton>
#include <QSlider>
#include <QTableWidget>
#include <QToolBar>
#include <QToolButton>
#include <QTreeWidget>
#include <fstream>
#include <tuple>

#include "../io/structure_set.h"
#include "gui/panels/check_panel.h"
#include "gui/panels/mesh_card.h"
#include "gui/panels/mesh_panel.h"
#include "gui/views/slice_slider.h"
#include "gui/views/space_view.h"
#include "gui/window/label_actions.h"
#include "gui/window/label_dialog.h"
#include "gui/window/message_bar.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/mesh_checker.h"
#include "gui/workbench/run_state.h"
#include "image/surface_fit.h"
#include "io/mesh/mesh_io.h"
#include "io/volume/volume_io.h"
#include "mesh/simplex_mesh.h"
#include "step/simulation_parameters.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class CheckTest : public PausedPhantomTest {
 protected:
  CheckPanel& panel() { return window_->panels().check(); }
  QTableWidget& table() { return *panel().findChild<QTableWidget*>(); }
  QString cell(const QString& row, int column) {
    for (int r = 0; r < table().rowCount(); ++r)
      if (table().verticalHeaderItem(r)->text().startsWith(row)) return table().item(r, column)->text();
    return "no such row";
  }
  LabelActions& labels() { return *window_->findChild<LabelActions*>(); }
  /// Writes a ball of radius 14 mm at the centre with label 5, and a small one with label 2.
  QString write_ball(double shift_mm = 0) {
    const VolumeGeometry grid = bench().session().volume().geometry();
    Volume volume(grid, VoxelType::UInt8);
    const auto voxels = volume.voxels<std::uint8_t>();
    const Eigen::Vector3d middle = grid.centre_mm();
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i) {
          const Eigen::Vector3d at = grid.world_from_index() * Eigen::Vector3d(i, j, k);
          std::uint8_t& voxel = voxels[volume.offset(i, j, k)];
          if ((at - middle - Eigen::Vector3d(shift_mm, 0, 0)).norm() < 14) voxel = 5;
          if ((at - middle - Eigen::Vector3d(0, 24, 0)).norm() < 4) voxel = 2;
        }
    const QString path = folder_.filePath("truth.nii.gz");
    write_labels(path.toStdString(), volume);
    return path;
  }
  Eigen::Isometry3d axes_of_volume() {
    const VolumeGeometry& grid = bench().session().volume().geometry();
    const Eigen::Vector3d voxel(grid.size[0] / 2, grid.size[1] / 2, grid.size[2] / 2);
    Eigen::Isometry3d axes(Eigen::Translation3d(grid.world_from_index() * voxel));
    axes.linear() = grid.direction;
    return axes;
  }
  /// Writes a body at the centre, an organ in it, and a region that lacks the middle slice of the organ.
  QString write_regions() {
    std::vector<double> gap = test::positions_every_2_mm(8);
    std::erase(gap, 0);
    const QString path = folder_.filePath("rt.dcm");
    std::ofstream(path.toStdString(), std::ios::binary) << test::structure_set_of_squares(
        axes_of_volume(),
        {{"body", 18, test::positions_every_2_mm(18)}, {"organ", 8, test::positions_every_2_mm(8)}, {"gap", 8, gap}});
    return path;
  }
  void load_reference(const QString& path) {
    labels().load_reference(path);
    ASSERT_TRUE(wait_until([this] { return scene().meshes[0].reference.has_value(); }))
        << window_->messages().text().toStdString();
  }
  void show_check_panel() {
    window_->panels().show_panel("Check");
    QApplication::processEvents();
  }
  void show_checked() {
    show_check_panel();
    ASSERT_TRUE(wait_until([this] { return panel().checker().of(scene().meshes[0].id) != nullptr; }));
  }
};

TEST_F(CheckTest, TheTableShowsMeasurementsAndFollowsTheMesh) {
  show_checked();
  // A sphere of 12 mm: 7.24 ml and 18.1 cm2, its mesh a little less; the phantom is bright there.
  EXPECT_NEAR(cell("Volume", 0).section(' ', 0, 0).toDouble(), 7.1, 0.3);
  EXPECT_NEAR(cell("Area", 0).section(' ', 0, 0).toDouble(), 18, 0.6);
  const auto inside = panel().checker().checks().at(0).inside;
  ASSERT_TRUE(inside);
  EXPECT_NEAR(cell("Mean", 0).toDouble(), inside->mean, 0.01 * inside->mean);
  EXPECT_EQ(cell("Dice", 0), "");
  load_reference(write_ball());
  ASSERT_TRUE(wait_until([this] { return !cell("Dice", 0).isEmpty(); }));
  EXPECT_TRUE(cell("Reference", 0).startsWith("5 "));  // the label below the mesh
  // Balls of 12 and 14 mm: 2 * 12^3 / (12^3 + 14^3), and 2 mm between their surfaces.
  EXPECT_NEAR(cell("Dice", 0).toDouble(), 0.773, 0.03);
  EXPECT_NEAR(cell("ASSD", 0).section(' ', 0, 0).toDouble(), 2, 0.4);
  EXPECT_NEAR(cell("HD95", 0).section(' ', 0, 0).toDouble(), 2.3, 0.6);
  bench().apply(AddMesh{"new", Seed{bench().view.crosshair_mm + Eigen::Vector3d(0, 24, 0), 4}, {}, 0});
  bench().pause();
  EXPECT_TRUE(wait_until([this] { return table().columnCount() == 2 && !cell("Volume", 1).isEmpty(); }));
  const QString csv = folder_.filePath("meshes.csv");
  panel().save_to(csv);
  QFile file(csv);
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  const QStringList lines = QString::fromUtf8(file.readAll()).split('\n', Qt::SkipEmptyParts);
  ASSERT_EQ(lines.size(), 3);
  EXPECT_EQ(lines[1].split(',').size(), lines[0].split(',').size());
  EXPECT_EQ(lines[2].split(',').size(), lines[0].split(',').size());
  EXPECT_TRUE(lines[1].startsWith("object,7"));
  bench().apply(Undo{});
  bench().apply(Undo{});
  EXPECT_FALSE(scene().meshes[0].reference.has_value());  // the reference is a separate undo step
}

TEST_F(CheckTest, ALabelVolumeOnAnotherGridIsResampledAndReported) {
  const VolumeGeometry grid = bench().session().volume().geometry();
  VolumeGeometry coarse = grid;
  coarse.spacing_mm *= 2;
  for (int& size : coarse.size) size /= 2;
  Volume volume(coarse, VoxelType::UInt8);
  const auto voxels = volume.voxels<std::uint8_t>();
  std::fill(voxels.begin(), voxels.end(), std::uint8_t{1});
  write_labels(folder_.filePath("coarse.nii.gz").toStdString(), volume);
  labels().load_reference(folder_.filePath("coarse.nii.gz"));
  ASSERT_TRUE(wait_until([this] { return scene().meshes[0].reference.has_value(); }));
  EXPECT_TRUE(window_->messages().text().contains("another grid")) << window_->messages().text().toStdString();
}

TEST_F(CheckTest, NothingIsMeasuredWhileThePanelIsHidden) {
  bench().advance_steps(5);
  QApplication::processEvents();
  EXPECT_TRUE(panel().checker().checks().empty());
}

TEST_F(CheckTest, SurfacesAreColouredByTheirDistanceOnAScale) {
  load_reference(write_ball(4));
  auto* space = &window_->views().space();
  window_->actions()[Act::Slices3d]->trigger();
  const auto colours_in = [&] {
    const QImage picture = space->grabFramebuffer();
    int blue = 0, orange = 0;
    for (int y = 0; y < picture.height(); y += 2)
      for (int x = 0; x < picture.width() - 40; x += 2) {
        const QColor c = picture.pixelColor(x, y);
        blue += c.blue() > c.red() + 20;
        orange += c.red() > c.blue() + 60;
      }
    return std::pair(blue, orange);
  };
  EXPECT_GT(colours_in().second, 200);  // colour of the mesh
  const int before = colours_in().first;
  show_check_panel();
  panel().findChild<QComboBox*>()->setCurrentIndex(1);
  ASSERT_TRUE(wait_until([this] { return bench().view.surface_values != nullptr; }));
  const SurfaceValues& values = *bench().view.surface_values;
  ASSERT_TRUE(values.of_mesh.contains(scene().meshes[0].id));
  const auto& of_mesh = values.of_mesh.at(scene().meshes[0].id);
  ASSERT_EQ(of_mesh.size(), scene().meshes[0].mesh.positions.size());
  EXPECT_NEAR(*std::max_element(of_mesh.begin(), of_mesh.end()), 6, 1);
  EXPECT_GT(colours_in().first, before + 200);
  // The colour scale at the right: dark blue at the bottom, yellow at the top.
  const QImage picture = space->grabFramebuffer();
  const double ratio = space->devicePixelRatio();
  const auto at = [&](double x, double y) { return picture.pixelColor(QPoint(int(x * ratio), int(y * ratio))); };
  EXPECT_GT(at(space->width() - 18, 0.72 * space->height()).blue(),
            at(space->width() - 18, 0.72 * space->height()).red());
  EXPECT_GT(at(space->width() - 18, 0.22 * space->height()).red(), 180);
  panel().findChild<QComboBox*>()->setCurrentIndex(0);
  EXPECT_EQ(bench().view.surface_values, nullptr);
}

TEST_F(CheckTest, TheWorstPlaceIsWhereTheMeshIsFarthestFromItsReference) {
  load_reference(write_ball(4));  // too far to the right: -x is 12 - (14 - 4) = 2 mm off, +x 6 mm
  const Eigen::Vector3d middle = bench().session().volume().geometry().centre_mm();
  window_->actions()[Act::WorstFit]->trigger();
  ASSERT_TRUE(wait_until([&] { return (bench().view.crosshair_mm - middle).norm() > 5; }));
  const Eigen::Vector3d first = bench().view.crosshair_mm;
  EXPECT_LT((first - middle - Eigen::Vector3d(12, 0, 0)).norm(), 4);
  EXPECT_TRUE(window_->messages().text().contains("from the reference"));
  window_->actions()[Act::WorstFit]->trigger();
  EXPECT_GT((bench().view.crosshair_mm - first).norm(), 1.5);  // the next
  EXPECT_TRUE(window_->messages().text().contains("place 2"));
}

TEST_F(CheckTest, WithoutAReferenceTheWorstPlaceIsFarthestFromTheImageEdge) {
  // The ball of the phantom has a radius of 16 mm; the mesh fits it except for a dent.
  SimplexMesh mesh = make_sphere(bench().session().volume().geometry().centre_mm(), 16, 3);
  const Eigen::Vector3f middle = bench().session().volume().geometry().centre_mm().cast<float>();
  for (Eigen::Vector3f& p : mesh.positions)
    if ((p - middle).normalized().z() > 0.9f) p = middle + (p - middle) * 0.82f;
  const std::vector<float> distances = edge_distances(mesh, bench().session().volume());
  const std::vector<SurfaceLocation> worst = worst_locations(mesh, distances);
  ASSERT_FALSE(worst.empty());
  EXPECT_GT((worst.front().position_mm.cast<float>() - middle).normalized().z(), 0.85f);
  EXPECT_GT(worst.front().value, 1.5);
  EXPECT_GE(worst.front().value, worst.back().value);
}

TEST_F(CheckTest, TickedLabelsBecomeMeshes) {
  labels().meshes_from_labels(write_ball());
  ASSERT_TRUE(wait_until([this] { return window_->findChild<LabelDialog*>() != nullptr; }));
  auto* dialog = window_->findChild<LabelDialog*>();
  auto* list = dialog->findChild<QTreeWidget*>();
  auto* make = dialog->findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok);
  ASSERT_EQ(list->topLevelItemCount(), 2);
  EXPECT_EQ(list->topLevelItem(1)->text(0), "5");
  EXPECT_NEAR(list->topLevelItem(1)->text(3).section(' ', 0, 0).toDouble(), 11.5, 0.2);  // ml of a ball of 14 mm
  EXPECT_FALSE(make->isEnabled());
  list->topLevelItem(1)->setCheckState(0, Qt::Checked);
  ASSERT_TRUE(make->isEnabled());
  make->click();
  ASSERT_TRUE(wait_until([this] { return scene().meshes.size() == 2; }));
  bench().pause();
  const MeshItem& made = scene().meshes[1];
  ASSERT_TRUE(made.start && made.start->mesh);
  EXPECT_EQ(made.start->value, 5);
  const Eigen::Vector3f middle = bench().session().volume().geometry().centre_mm().cast<float>();
  for (const Eigen::Vector3f& p : made.start->mesh->positions) ASSERT_NEAR((p - middle).norm(), 14, 1.2);
  bench().apply(Undo{});
  EXPECT_EQ(scene().meshes.size(), 1u);
  bench().apply(Redo{});
  ASSERT_EQ(scene().meshes.size(), 2u);
  // It moves like any mesh, and a reset restores the surface of its label.
  bench().advance_steps(3);
  bench().apply(ResetPose{scene().meshes[1].id});
  EXPECT_EQ(scene().meshes[1].mesh.positions, scene().meshes[1].start->mesh->positions);
}

/// Contours have no grid and may be nested: each region becomes a mesh. A slice without contours is reported.
TEST_F(CheckTest, RegionsOfAStructureSetBecomeMeshes) {
  labels().meshes_from_labels(write_regions());
  ASSERT_TRUE(wait_until([this] { return window_->findChild<LabelDialog*>() != nullptr; }));
  auto* dialog = window_->findChild<LabelDialog*>();
  auto* list = dialog->findChild<QTreeWidget*>();
  ASSERT_EQ(list->topLevelItemCount(), 3);
  for (int row = 0; row < 3; ++row) list->topLevelItem(row)->setCheckState(0, Qt::Checked);
  dialog->findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok)->click();
  ASSERT_TRUE(wait_until([this] { return scene().meshes.size() == 4; }));
  bench().pause();
  EXPECT_TRUE(window_->messages().text().contains("rt.dcm': 1 slice between"))
      << window_->messages().text().toStdString();
  for (const auto& [mesh, name, half_mm] : {std::tuple(1, "body", 18.0), std::tuple(2, "organ", 8.0)}) {
    const MeshItem& made = scene().meshes[static_cast<std::size_t>(mesh)];
    EXPECT_EQ(made.name, name);
    ASSERT_TRUE(made.start && made.start->mesh);
    double most = 0;
    for (const Eigen::Vector3f& p : made.start->mesh->positions)
      most = std::max(most, (axes_of_volume().inverse() * p.cast<double>())[0]);
    EXPECT_NEAR(most, half_mm, 0.6);
  }
}

TEST_F(CheckTest, RegionsOfAStructureSetAreReferences) {
  load_reference(write_regions());
  EXPECT_EQ(scene().meshes[0].reference->value, 1);  // a ball of 12 mm lies in the body
  show_check_panel();
  ASSERT_TRUE(wait_until([this] { return !cell("Dice", 0).isEmpty(); }));
  // Compared with a cube of 36 mm edge length (slices of 2 mm), without the organ, which is a separate label.
  EXPECT_GT(cell("Dice", 0).toDouble(), 0.1);
  EXPECT_LT(cell("Dice", 0).toDouble(), 0.4);
}

TEST_F(CheckTest, ASurfaceFileBecomesAMesh) {
  const Eigen::Vector3d at = bench().view.crosshair_mm + Eigen::Vector3d(10, 0, 0);
  write_mesh(folder_.filePath("liver.stl").toStdString(), make_sphere(at, 7, 2));
  labels().mesh_from_file(folder_.filePath("liver.stl"));
  ASSERT_TRUE(wait_until([this] { return scene().meshes.size() == 2; }));
  EXPECT_EQ(scene().meshes[1].name, "liver");
  EXPECT_LT((scene().meshes[1].seed.centre_mm - at).norm(), 1);
  window_->messages().clear();
  QFile open(folder_.filePath("open.stl"));
  ASSERT_TRUE(open.open(QIODevice::WriteOnly));
  open.write("solid a\nendsolid a\n");
  open.close();
  labels().mesh_from_file(folder_.filePath("open.stl"));
  EXPECT_TRUE(wait_until([this] { return window_->messages().text().contains("open.stl': "); }))
      << window_->messages().text().toStdString();
  EXPECT_EQ(scene().meshes.size(), 2u);
}

TEST_F(CheckTest, AViewHasASliceNumberAndASlider) {
  SliceSlider* slider = nullptr;
  for (SliceSlider* one : window_->findChildren<SliceSlider*>())
    if (one->accessibleName().startsWith("Axial")) slider = one;
  ASSERT_NE(slider, nullptr);
  EXPECT_EQ(slider->maximum(), 64);
  const double before = bench().view.crosshair_mm.z();
  const int number = slider->value();
  slider->setValue(number + 7);
  EXPECT_NEAR(bench().view.crosshair_mm.z(), before + 7, 1e-6);
  axial().move_by_slices(-3);
  EXPECT_EQ(slider->value(), number + 4);
  // The scale bar, at the lower right, is one of the annotations.
  const auto bright = [this] {
    const QImage picture = axial().grabFramebuffer();
    int count = 0;
    for (int x = picture.width() / 2; x < picture.width() - 4; ++x)
      count += qGray(picture.pixel(x, picture.height() - int(9 * axial().devicePixelRatio()))) > 150;
    return count;
  };
  EXPECT_GT(bright(), 20);
  window_->actions()[Act::Annotations]->trigger();
  EXPECT_LT(bright(), 5);
}

TEST_F(CheckTest, NamesCanBeHidden) {
  bench().set_title("Doe, Jane", "chest");
  const auto upper_left = [this] {
    const QImage picture = axial().grabFramebuffer();
    const double ratio = axial().devicePixelRatio();
    return picture.copy(0, int(22 * ratio), int(120 * ratio), int(40 * ratio));
  };
  const QImage with = upper_left();
  window_->actions()[Act::Names]->trigger();
  EXPECT_FALSE(bench().view.show_names);
  EXPECT_NE(upper_left(), with);
  bench().set_title("", "");
  const QImage without = upper_left();
  window_->actions()[Act::Names]->trigger();
  EXPECT_EQ(upper_left(), without);
}

TEST_F(CheckTest, PointsAreHoveredDraggedAndResizedIn3d) {
  auto* space = &window_->views().space();
  bench().view.opacity = 0.5f;  // the mesh is transparent
  const Eigen::Vector3d middle = bench().session().volume().geometry().centre_mm();
  bench().apply(AddPoint{bench().view.active_mesh, middle, MarkKind::Inside, 4});
  space->grabFramebuffer();
  const QPointF at = space->rect().center();  // the view is centred
  mouse(*space, QEvent::MouseMove, at, Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(bench().view.hovered_point, scene().points[0].id);
  wheel(*space, at, 2);
  EXPECT_NEAR(scene().points[0].radius_mm, 4 * 1.1 * 1.1, 1e-6);
  drag(*space, at, at + QPointF(30, 0));
  EXPECT_EQ(bench().view.selected_point, scene().points[0].id);
  EXPECT_GT((scene().points[0].position_mm - middle).norm(), 3);
  bench().apply(Undo{});
  EXPECT_LT((scene().points[0].position_mm - middle).norm(), 1e-9);  // one undo step
  bench().apply(Undo{});
  EXPECT_NEAR(scene().points[0].radius_mm, 4, 1e-9);
  // A point behind an opaque mesh is hidden, and a drag rotates the view.
  bench().view.opacity = 1;
  mouse(*space, QEvent::MouseMove, at + QPointF(1, 0), Qt::NoButton, Qt::NoButton);
  EXPECT_EQ(bench().view.hovered_point, 0u);
}

TEST_F(CheckTest, TheWheelOverAPointChangesItsReachAndStrength) {
  const Eigen::Vector3d at = bench().view.crosshair_mm + Eigen::Vector3d(5, 5, 0);
  const ItemId mesh = bench().view.active_mesh;
  bench().apply(AddPoint{mesh, at, MarkKind::Boundary});
  const QPointF pixel = axial().pixel_of(at);
  const auto& values = scene().meshes[0].parameters.values[static_cast<int>(ForceId::Attraction)];
  const float weight = values[0], order = values[1];
  const double z = bench().view.crosshair_mm.z();
  wheel(axial(), pixel, 2);
  EXPECT_EQ(scene().meshes[0].parameters.values[static_cast<int>(ForceId::Attraction)][1], order + 2);
  wheel(axial(), pixel, 1, Qt::ShiftModifier);
  EXPECT_NEAR(scene().meshes[0].parameters.values[static_cast<int>(ForceId::Attraction)][0], weight * 1.15f, 1e-4);
  EXPECT_EQ(bench().view.crosshair_mm.z(), z);
  // Elsewhere the wheel changes the slice, even if a point passes under the mouse.
  wheel(axial(), pixel + QPointF(40, 0), 1);
  EXPECT_NE(bench().view.crosshair_mm.z(), z);
  wheel(axial(), pixel, -1);
  EXPECT_EQ(bench().view.crosshair_mm.z(), z);
}

TEST_F(CheckTest, ASpringGoesFromAPointToTheVertexThatItPulls) {
  const Eigen::Vector3d middle = bench().view.crosshair_mm;
  window_->actions()[Act::Annotations]->trigger();
  const auto orange_at = [&](double x_mm) {
    const QImage picture = axial().grabFramebuffer();
    const QPointF place = axial().pixel_of(middle + Eigen::Vector3d(x_mm, 0, 0)) * axial().devicePixelRatio();
    int most = -255;
    for (int dy = -3; dy <= 3; ++dy) {
      const QColor colour = picture.pixelColor(place.toPoint() + QPoint(0, dy));
      most = std::max(most, colour.red() - colour.blue());
    }
    return most;
  };
  EXPECT_LT(orange_at(18), 30);
  bench().apply(AddPoint{bench().view.active_mesh, middle + Eigen::Vector3d(24, 0, 0), MarkKind::Boundary});
  EXPECT_GT(orange_at(18), 60);
}

TEST_F(CheckTest, ASelfIntersectionIsExplainedWithARemedy) {
  // One vertex pushed through the mesh folds it.
  Scene folded = scene();
  folded.meshes[0].mesh.positions[0] -=
      1.9f * (folded.meshes[0].mesh.positions[0] - bench().session().volume().geometry().centre_mm().cast<float>());
  const Volume volume = bench().session().volume();
  bench().open(folded, volume);
  bench().advance_steps(1);
  ASSERT_FALSE(faults_of(bench(), 0).isEmpty());
  EXPECT_TRUE(advice_of(bench(), 0).contains("Smoothing"));
  bool shown = false;
  EXPECT_TRUE(wait_until([&] {
    for (const QLabel* label : window_->findChild<MeshPanel*>()->cards()[0]->findChildren<QLabel*>())
      shown |= label->text() == "overlaps itself" && label->toolTip().contains("Smoothing");
    return shown;
  }));
}

TEST_F(CheckTest, ToolsThatDoNotFitAreInTheExtensionMenu) {
  window_->resize(800, 600);
  QApplication::processEvents();
  auto* bar = window_->findChild<QToolBar*>("tools");
  const QWidget* undo = bar->widgetForAction(window_->actions()[Act::Fit]);
  auto* more = bar->findChild<QToolButton*>("qt_toolbar_ext_button");
  ASSERT_NE(more, nullptr);
  EXPECT_TRUE(undo->isVisible() || (more->isVisible() && more->width() >= 16));
}

}  // namespace
}  // namespace simplexseg
