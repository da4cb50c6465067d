// SPDX-License-Identifier: Apache-2.0
// What the window shows of the fields that meshes learn: that they do, what is wrong with them, and where they are.
#include <QAction>
#include <QLabel>

#include "forces/evidence.h"
#include "gui/views/drawn_scene.h"
#include "gui/window/message_bar.h"
#include "gui/window/status_line.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class FieldTest : public WindowTest {
 protected:
  /// The phantom with a mesh that is drawn to its field; `direction`: of the volume's axes.
  void open_learning(const Eigen::Matrix3d& direction = Eigen::Matrix3d::Identity()) {
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
  bool learned() { return scene().meshes[0].has_field(); }
  const QLabel* learning() { return static_cast<StatusLine*>(window_->statusBar())->learning(); }
  /// How much more red than blue a place in a slice is.
  int orange(int slice, const Eigen::Vector3d& world_mm) {
    SliceView& view = window_->views().slice(slice);
    const QImage picture = view.grabFramebuffer();
    const QColor colour = picture.pixelColor((view.pixel_of(world_mm) * view.devicePixelRatio()).toPoint());
    return colour.red() - colour.blue();
  }
};

TEST_F(FieldTest, TheStatusLineSaysWhoLearns) {
  open_learning();
  EXPECT_TRUE(learning()->text().isEmpty());
  QStringList told;
  QObject::connect(&bench(), &Workbench::learning_changed, [&] { told << learning()->text(); });
  bench().run();
  ASSERT_TRUE(wait_until([&] { return learned(); }));
  ASSERT_FALSE(told.isEmpty());
  EXPECT_EQ(told[0], "learning mesh 'object'");
  EXPECT_TRUE(wait_until([&] { return learning()->text().isEmpty(); }));
}

TEST_F(FieldTest, AFieldThatLeaksIsSaidOnceForEachAction) {
  open_phantom(16);
  // Nothing holds what looks like the object.
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
  ASSERT_TRUE(learned());
  ASSERT_EQ(warnings.size(), 1);
  EXPECT_TRUE(warnings[0].contains("'object' leaks")) << warnings[0].toStdString();
  EXPECT_TRUE(warnings[0].contains("mark what is outside")) << warnings[0].toStdString();
  EXPECT_EQ(window_->messages().text(), warnings[0]);
  // Learned anew with each movement of a drag, and said once; after another action, which did not help, again.
  ItemId point = 0;
  const Eigen::Vector3d middle = bench().view.crosshair_mm;
  bench().apply(AddPoint{bench().view.active_mesh, middle, MarkKind::Inside, 3}, &point);
  for (int n = 1; n <= 3; ++n) {
    bench().apply(MovePoint{point, middle + Eigen::Vector3d(n, 0, 0), true});
    bench().advance_steps(10);
  }
  ASSERT_TRUE(wait_until([&] { return warnings.size() > 1; }));
  EXPECT_EQ(warnings[1], warnings[0]);
  // What is so no more is not shown any longer.
  ASSERT_EQ(window_->messages().text(), warnings[0]);
  bench().apply(DeleteMesh{bench().view.active_mesh});
  EXPECT_FALSE(window_->messages().isVisible());
}

TEST_F(FieldTest, TheOverlayTintsTheObjectInAllSlices) {
  const Eigen::Matrix3d tilted = Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const Eigen::Matrix3d& direction : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), tilted}) {
    open_learning(direction);
    bench().advance_steps(1);
    ASSERT_TRUE(learned());
    const Eigen::Vector3d centre = bench().session().volume().geometry().centre_mm();
    // Off the mesh's outline (8 mm) and inside the object (16 mm); and outside of it.
    const Eigen::Vector3d inside[] = {{12, 0, 0}, {0, 12, 0}, {0, 0, 12}};
    const Eigen::Vector3d outside[] = {{23, 0, 0}, {0, 23, 0}, {0, 0, 23}};
    for (int slice = 0; slice < 3; ++slice) {
      const int along = slice == 1 ? 1 : 0;  // lies in the slice
      EXPECT_LT(orange(slice, centre + inside[along]), 10);
    }
    EXPECT_EQ(window_->drawn().buffers().update_field(bench().session(), bench().view), nullptr);  // holds nothing
    window_->actions()[Act::ShowField]->trigger();
    for (int slice = 0; slice < 3; ++slice) {
      const int along = slice == 1 ? 1 : 0;
      EXPECT_GT(orange(slice, centre + inside[along]), 40) << slice;
      EXPECT_LT(orange(slice, centre + outside[along]), 10) << slice;
    }
    // It follows what is learned: the place is said not to belong to the object.
    ASSERT_TRUE(bench().apply(AddPoint{bench().view.active_mesh, centre + inside[0], MarkKind::Outside, 3}));
    bench().advance_steps(1);
    EXPECT_LT(orange(0, centre + inside[0] + Eigen::Vector3d(1.5, 1.5, 0)), 20);
    window_->actions()[Act::ShowField]->trigger();
    EXPECT_LT(orange(2, centre - inside[0]), 10);
  }
}

TEST_F(FieldTest, TheOverlaySaysWhenNothingIsLearned) {
  open_learning();
  bench().view.show_annotations = true;
  const QImage before = axial().grabFramebuffer();
  window_->actions()[Act::ShowField]->trigger();
  EXPECT_NE(axial().grabFramebuffer(), before);  // the text
}

}  // namespace
}  // namespace simplexseg
