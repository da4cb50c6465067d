// SPDX-License-Identifier: Apache-2.0
// Fields of segmentations in the window: the solving state, warnings, and the overlay.
#include <QAction>
#include <QLabel>
#include <QRegularExpression>
#include <algorithm>

#include "forces/evidence.h"
#include "gui/panels/intensity_panel.h"
#include "gui/views/drawn_scene.h"
#include "gui/window/message_bar.h"
#include "gui/window/state_chip.h"
#include "gui/window/status_line.h"
#include "gui/workbench/run_state.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class FieldTest : public WindowTest {
 protected:
  /// Opens the phantom with a mesh attracted to its field; `direction`: axes of the volume.
  void open_with_field(const Eigen::Matrix3d& direction = Eigen::Matrix3d::Identity()) {
    open_phantom(8);
    Scene scene = this->scene();
    const Volume& plain = bench().session().volume();
    VolumeGeometry geometry = plain.geometry();
    geometry.direction = direction;
    geometry.origin_mm += plain.geometry().centre_mm() - geometry.centre_mm();
    Volume volume(geometry, plain.type());
    std::memcpy(volume.data(), plain.data(), plain.bytes());
    ForceParameters& parameters = scene.meshes[0].parameters;
    parameters.values[static_cast<int>(ForceId::Evidence)][0] = 1;
    parameters.values[static_cast<int>(ForceId::Evidence)][EvidenceForce::source] = 0;
    bench().open(std::move(scene), std::move(volume));
    bench().view.show_annotations = false;
    QApplication::processEvents();
  }
  bool has_field() { return scene().meshes[0].has_field(); }
  const QLabel* solving() { return static_cast<StatusLine*>(window_->statusBar())->solving(); }
  /// Red minus blue of a pixel in a slice.
  int orange(int slice, const Eigen::Vector3d& world_mm) {
    SliceView& view = window_->views().slice(slice);
    const QImage picture = view.grabFramebuffer();
    const QColor colour = picture.pixelColor((view.pixel_of(world_mm) * view.devicePixelRatio()).toPoint());
    return colour.red() - colour.blue();
  }
};

TEST_F(FieldTest, TheStatusLineNamesTheSegmentationBeingSolved) {
  open_with_field();
  EXPECT_TRUE(solving()->text().isEmpty());
  QStringList texts;
  QObject::connect(&bench(), &Workbench::solving_changed, [&] { texts << solving()->text(); });
  bench().run();
  ASSERT_TRUE(wait_until([&] { return has_field(); }));
  ASSERT_FALSE(texts.isEmpty());
  EXPECT_TRUE(QRegularExpression("^solving 'object' \\d+%$").match(texts[0]).hasMatch()) << texts[0].toStdString();
  EXPECT_TRUE(wait_until([&] { return solving()->text().isEmpty(); }));
}

TEST_F(FieldTest, TheStateHasAPercentageWhileAFieldIsSolved) {
  open_with_field();
  QStringList texts;
  std::vector<int> percentages;
  QObject context;
  const auto note = [&] {
    if (bench().session().solving_mesh() == 0) return;
    texts << window_->findChild<StateChip*>("state_chip")->text()
          << text_of(mesh_state(bench(), window_->loop(), 0), bench().solving_percent());
    percentages.push_back(bench().solving_percent());
  };
  QObject::connect(&bench(), &Workbench::solving_changed, &context, note);
  QObject::connect(&bench(), &Workbench::solving_progressed, &context, note);
  bench().run();
  ASSERT_TRUE(wait_until([&] { return has_field() && bench().session().solving_mesh() == 0; }));
  ASSERT_FALSE(texts.isEmpty());
  for (const QString& text : texts)
    EXPECT_TRUE(QRegularExpression("^solving \\d+%$").match(text).hasMatch()) << text.toStdString();
  EXPECT_TRUE(std::ranges::is_sorted(percentages));
  EXPECT_LE(percentages.back(), 100);
  EXPECT_EQ(bench().solving_percent(), 0);
}

TEST_F(FieldTest, ASpreadingFieldIsReportedOncePerAction) {
  open_phantom(16);
  // A constant image: the object has no border.
  VolumeGeometry geometry;
  geometry.size = {32, 32, 32};
  geometry.origin_mm = bench().view.crosshair_mm - Eigen::Vector3d::Constant(15.5);
  Volume empty(geometry, VoxelType::Float32);
  for (float& voxel : empty.voxels<float>()) voxel = 50;
  Scene scene = this->scene();
  scene.meshes[0].parameters.values[static_cast<int>(ForceId::Evidence)][0] = 1;
  scene.meshes[0].parameters.values[static_cast<int>(ForceId::Evidence)][EvidenceForce::source] = 0;
  bench().open(std::move(scene), std::move(empty));
  QStringList warnings;
  QObject::connect(&bench(), &Workbench::message, [&](Severity severity, const QString& text) {
    if (severity == Severity::Warning) warnings << text;
  });
  bench().advance_steps(10);
  ASSERT_TRUE(has_field());
  ASSERT_EQ(warnings.size(), 1);
  EXPECT_TRUE(warnings[0].contains("'object' spreads")) << warnings[0].toStdString();
  EXPECT_TRUE(warnings[0].contains("Mark what is outside")) << warnings[0].toStdString();
  EXPECT_EQ(window_->messages().text(), warnings[0]);
  // The field is solved with each movement of a drag, but the warning is shown once; after another action it is shown
  // again.
  ItemId point = 0;
  const Eigen::Vector3d middle = bench().view.crosshair_mm;
  bench().apply(AddPoint{bench().view.active_mesh, middle, MarkKind::Inside, 3}, &point);
  for (int n = 1; n <= 3; ++n) {
    bench().apply(MovePoint{point, middle + Eigen::Vector3d(n, 0, 0), true});
    bench().advance_steps(10);
  }
  ASSERT_TRUE(wait_until([&] { return warnings.size() > 1; }));
  EXPECT_EQ(warnings[1], warnings[0]);
  // A warning that no longer applies disappears.
  ASSERT_EQ(window_->messages().text(), warnings[0]);
  bench().apply(DeleteMesh{bench().view.active_mesh});
  EXPECT_FALSE(window_->messages().isVisible());
}

TEST_F(FieldTest, TheOverlayTintsTheObjectInAllSlices) {
  const Eigen::Matrix3d tilted = Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const Eigen::Matrix3d& direction : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), tilted}) {
    open_with_field(direction);
    bench().advance_steps(1);
    ASSERT_TRUE(has_field());
    const Eigen::Vector3d centre = bench().session().volume().geometry().centre_mm();
    // Positions off the contour (8 mm) and inside the object (16 mm), and positions outside it.
    const Eigen::Vector3d inside[] = {{12, 0, 0}, {0, 12, 0}, {0, 0, 12}};
    const Eigen::Vector3d outside[] = {{23, 0, 0}, {0, 23, 0}, {0, 0, 23}};
    for (int slice = 0; slice < 3; ++slice) {
      const int along = slice == 1 ? 1 : 0;  // lies in the slice
      EXPECT_LT(orange(slice, centre + inside[along]), 10);
    }
    EXPECT_EQ(window_->drawn().buffers().update_field(bench().session(), bench().view), nullptr);  // no texture
    window_->actions()[Act::ShowField]->trigger();
    for (int slice = 0; slice < 3; ++slice) {
      const int along = slice == 1 ? 1 : 0;
      EXPECT_GT(orange(slice, centre + inside[along]), 40) << slice;
      EXPECT_LT(orange(slice, centre + outside[along]), 10) << slice;
    }
    // The tint follows the field: an outside point removes it.
    ASSERT_TRUE(bench().apply(AddPoint{bench().view.active_mesh, centre + inside[0], MarkKind::Outside, 3}));
    bench().advance_steps(1);
    EXPECT_LT(orange(0, centre + inside[0] + Eigen::Vector3d(1.5, 1.5, 0)), 20);
    window_->actions()[Act::ShowField]->trigger();
    EXPECT_LT(orange(2, centre - inside[0]), 10);
  }
}

TEST_F(FieldTest, TheOverlayReportsAMissingField) {
  open_with_field();
  bench().view.show_annotations = true;
  const QImage before = axial().grabFramebuffer();
  window_->actions()[Act::ShowField]->trigger();
  EXPECT_NE(axial().grabFramebuffer(), before);  // the text
}

TEST_F(FieldTest, ARangeWithoutEffectIsReportedUntilItIsCorrected) {
  open_with_field();
  window_->panels().show_panel("Intensity");
  const auto line = [&] {
    for (const QLabel* label : window_->findChild<IntensityPanel*>()->findChildren<QLabel*>())
      if (label->property("role") == "warning" && label->isVisible()) return label->text();
    return QString();
  };
  bench().advance_steps(5);
  ASSERT_TRUE(has_field());
  EXPECT_TRUE(line().isEmpty());
  const ItemId mesh = scene().meshes[0].id;
  for (const auto& [range, what] : {std::pair{IntensityRange{-1e6, 1e6}, "has no effect"},
                                    {IntensityRange{1e6, 2e6}, "nothing of the image"},
                                    {IntensityRange{-1e6, 60}, "most of the seed"}}) {
    ASSERT_TRUE(bench().apply(SetIntensityRange{mesh, range}));
    bench().pause();
    bench().advance_steps(1);
    EXPECT_TRUE(window_->messages().text().contains(what)) << window_->messages().text().toStdString();
    EXPECT_TRUE(line().contains(what)) << line().toStdString();
    QApplication::processEvents();
    if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES")) window_->grab().save(QString(folder) + "/range.png");
    ASSERT_TRUE(bench().apply(Undo{}));
    EXPECT_TRUE(window_->messages().text().isEmpty()) << window_->messages().text().toStdString();
    EXPECT_TRUE(line().isEmpty());
  }
}

}  // namespace
}  // namespace simplexseg
