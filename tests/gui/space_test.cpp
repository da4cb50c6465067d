// SPDX-License-Identifier: Apache-2.0
// Planes that cut the 3D view, and volume rendering: tests send events and check pixels.
#include <QAction>
#include <QMenu>
#include <QSettings>
#include <cmath>

#include "gui/look/theme.h"
#include "gui/views/space_view.h"
#include "gui/window/window_memory.h"
#include "study/phantom.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

class SpaceTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    bench().view.show_slices_3d = false;
    bench().view.show_annotations = false;
    bench().view.clip.image_on_caps = false;
    window_->views().show_alone(3);
    QApplication::processEvents();
    space().fit();
    drag(space(), QPointF(100, 100), QPointF(100, 150));  // from farther above
  }
  SpaceView& space() { return window_->views().space(); }
  void trigger(Act act) { window_->actions()[act]->trigger(); }
  Vector3d centre() { return bench().session().volume().geometry().centre_mm(); }
  QPointF pixel(const Vector3d& world_mm) { return space().map().pixel(world_mm).value_or(QPointF(-1, -1)); }
  QImage picture() { return space().grabFramebuffer(); }
  /// Saves a picture to the folder SIMPLEXSEG_PICTURES, if that is set.
  static void save(const QImage& image, const char* name) {
    const QString folder = qEnvironmentVariable("SIMPLEXSEG_PICTURES");
    if (!folder.isEmpty()) image.save(folder + "/" + name + ".png");
  }
  QColor colour_at(const QImage& image, const Vector3d& world_mm) {
    const QPointF at = pixel(world_mm) * space().devicePixelRatio();
    return image.pixelColor(static_cast<int>(at.x()), static_cast<int>(at.y()));
  }
  /// Offset of 11 mm from the centre to the place that is highest on the screen: far from the edge of a cap.
  Vector3d top() {
    Vector3d highest(0, 0, 11);
    for (int azimuth = 0; azimuth < 360; azimuth += 15)
      for (int degrees = 0; degrees < 90; degrees += 5) {
        const double a = azimuth * M_PI / 180, e = degrees * M_PI / 180;
        const Vector3d at(11 * std::cos(e) * std::cos(a), 11 * std::cos(e) * std::sin(a), 11 * std::sin(e));
        if (pixel(centre() + at).y() < pixel(centre() + highest).y()) highest = at;
      }
    return highest;
  }
  static bool close(const QColor& a, const QColor& b, int tolerance = 4) {
    return std::abs(a.red() - b.red()) <= tolerance && std::abs(a.green() - b.green()) <= tolerance &&
           std::abs(a.blue() - b.blue()) <= tolerance;
  }
  QColor colour_of(int mesh) {
    const Colour c = scene().meshes[static_cast<std::size_t>(mesh)].colour;
    return {c.red, c.green, c.blue};
  }
  /// Share of the places in a ring of a plane that have this colour.
  double share_of_ring(const QImage& image, const QColor& colour, const Vector3d& normal, double from_mm, double to_mm,
                       const Vector3d& middle) {
    const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    int all = 0, coloured = 0;
    for (double r = from_mm; r <= to_mm; r += (to_mm - from_mm) / 20 + 1e-9)
      for (int step = 0; step < 120; ++step) {
        const double angle = 2 * M_PI * step / 120;
        ++all;
        coloured += close(colour_at(image, middle + r * (std::cos(angle) * u + std::sin(angle) * v)), colour);
      }
    return static_cast<double>(coloured) / all;
  }
  int add_sphere(const Vector3d& at_mm, double radius_mm) {
    EXPECT_TRUE(bench().apply(AddMesh{"", {at_mm, radius_mm}, {}}));
    bench().pause();
    return static_cast<int>(scene().meshes.size()) - 1;
  }
};

const QColor kBackground = theme::kSpaceBackground;

TEST_F(SpaceTest, TheCapOfACutSphereIsClosedAndFlipShowsTheOtherHalf) {
  const QImage whole = picture();
  EXPECT_LT(share_of_ring(whole, colour_of(0), {0, 0, 1}, 0, 11.5, centre()), 0.1) << "lit, not flat";
  trigger(Act::ClipAxial);
  const QImage cut = picture();
  EXPECT_GT(share_of_ring(cut, colour_of(0), {0, 0, 1}, 0, 11.3, centre()), 0.99);
  save(whole, "whole"), save(cut, "cut_axial");
  EXPECT_TRUE(close(colour_at(cut, centre() + top()), kBackground))
      << "the upper half is removed; " << colour_at(cut, centre() + top()).name().toStdString();
  EXPECT_FALSE(close(colour_at(whole, centre() + top()), kBackground));
  // Flipped, the lower half is removed, and the view from above shows the lit upper half.
  EXPECT_TRUE(window_->actions()[Act::FlipAxial]->isEnabled());
  trigger(Act::FlipAxial);
  const QImage flipped = picture();
  EXPECT_FALSE(close(colour_at(flipped, centre() + top()), kBackground));
  EXPECT_TRUE(close(colour_at(flipped, centre() + Vector3d(0, -7, -9)), kBackground));
  EXPECT_FALSE(close(colour_at(cut, centre() + Vector3d(0, -7, -9)), kBackground));
  EXPECT_LT(share_of_ring(flipped, colour_of(0), {0, 0, 1}, 0, 11.3, centre()), 0.1);
  trigger(Act::ClipAxial);
  EXPECT_EQ(picture(), whole);
}

TEST_F(SpaceTest, NestedTouchingAndOverlappingMeshesHaveTheirOwnCaps) {
  const int inner = add_sphere(centre(), 5);
  const int touching = add_sphere(centre() + Vector3d(20.2, 0, 0), 8);
  const int overlapping = add_sphere(centre() + Vector3d(-14, 0, 0), 7);
  for (const bool reordered : {false, true}) {
    if (reordered) {
      ASSERT_TRUE(bench().apply(ReorderMesh{scene().meshes[1].id, 0}));
    }
    const auto at = [&](int mesh) { return reordered && mesh < 2 ? 1 - mesh : mesh; };
    bench().view.clip.on[0] = true;
    bench().view_edited();
    const QImage cut = picture();
    const Vector3d up(0, 0, 1);
    EXPECT_GT(share_of_ring(cut, colour_of(at(inner)), up, 0, 4.6, centre()), 0.97) << reordered;
    const double outer = share_of_ring(cut, colour_of(at(0)), up, 5.5, 6.4, centre());
    EXPECT_GT(outer, 0.97) << reordered;
    EXPECT_GT(share_of_ring(cut, colour_of(touching), up, 0, 7.3, centre() + Vector3d(20.2, 0, 0)), 0.98);
    EXPECT_GT(share_of_ring(cut, colour_of(overlapping), up, 0, 6.3, centre() + Vector3d(-14, 0, 0)), 0.98);
  }
}

TEST_F(SpaceTest, SeveralPlanesLeaveOneClosedPart) {
  for (const Act act : {Act::ClipAxial, Act::ClipSagittal, Act::ClipCoronal}) trigger(act);
  const QImage cut = picture();
  int all = 0, coloured = 0;
  // The kept part is inferior, right and posterior: -z, -x, +y.
  for (double a = 0.3; a < 10.8; a += 0.5)
    for (double b = 0.3; std::hypot(a, b) < 10.8; b += 0.5)
      for (const Vector3d& at : {Vector3d(-a, b, 0), Vector3d(0, b, -a), Vector3d(-a, 0, -b)}) {
        ++all;
        coloured += close(colour_at(cut, centre() + at), colour_of(0));
      }
  EXPECT_GT(coloured, 0.98 * all);
  for (const Vector3d& removed : {top(), Vector3d(11, 0, 0)})
    EXPECT_TRUE(close(colour_at(cut, centre() + removed), kBackground)) << removed.transpose();
  // The count of faces leaves nothing behind: without planes, the picture is that of the beginning.
  for (QAction* entry : window_->findChild<QMenu*>("clip_menu")->actions())
    if (entry->text() == "&Nothing cut") entry->trigger();
  EXPECT_FALSE(window_->actions()[Act::ClipAxial]->isChecked());
  EXPECT_FALSE(close(colour_at(picture(), centre() + top()), kBackground));
}

TEST_F(SpaceTest, TheCapShowsTheImageInTheColourOfTheObject) {
  ASSERT_TRUE(bench().apply(AddMesh{"", {centre() + Vector3d(16, 0, 0), 6}, {}}));  // across the edge of the ball
  bench().pause();
  const int mesh = static_cast<int>(scene().meshes.size()) - 1;
  bench().view.window = 200, bench().view.level = 100;  // background 50: dark grey; ball 150: bright grey
  for (const Act act : {Act::ClipAxial, Act::ClipFree}) {
    trigger(act);
    if (act == Act::ClipFree) {
      bench().view.clip.free_normal = Vector3d(0.1, 0.1, 1).normalized();
      bench().view.clip.free_point_mm = centre();
    }
    trigger(Act::ImageOnCaps);
    ASSERT_TRUE(bench().view.clip.image_on_caps);
    const Vector3d n = act == Act::ClipFree ? bench().view.clip.free_normal : Vector3d(0, 0, 1);
    const auto on_plane = [&](double x) -> Vector3d { return centre() + Vector3d(x, 0, -n.x() * x / n.z()); };
    const QImage image = picture();
    const int inside = colour_at(image, on_plane(13)).lightness(), outside = colour_at(image, on_plane(20)).lightness();
    EXPECT_GT(inside, colour_of(mesh).lightness() + 10);
    EXPECT_LT(outside, colour_of(mesh).lightness() - 10);
    trigger(Act::ImageOnCaps);
    const QImage plain = picture();
    EXPECT_TRUE(close(colour_at(plain, on_plane(13)), colour_of(mesh)));
    EXPECT_TRUE(close(colour_at(plain, on_plane(20)), colour_of(mesh)));
    trigger(act);
  }
}

TEST_F(SpaceTest, TheFreePlaneIsPlacedMovedAndTiltedWithTheMouse) {
  bench().view.show_annotations = true;  // with them, the handle is shown
  trigger(Act::ClipFree);
  ClipState& clip = bench().view.clip;
  ASSERT_TRUE(clip.on[3] && clip.free_placed);
  const Vector3d towards = space().map().axis(2), start = clip.free_point_mm;
  EXPECT_LT((clip.free_normal - towards).norm(), 1e-9);
  EXPECT_LT((start - bench().view.crosshair_mm).norm(), 1e-9);
  bench().view.show_annotations = false;
  EXPECT_GT(share_of_ring(picture(), colour_of(0), towards, 0, 11.2, centre()), 0.99);
  bench().view.show_annotations = true;
  // The normal points at the viewer: upwards moves the plane away by as much as the mouse moves.
  const double mm_per_pixel = space().map().mm_per_pixel(start);
  drag(space(), pixel(start), pixel(start) - QPointF(0, 30));
  EXPECT_LT((clip.free_point_mm - (start - 30 * mm_per_pixel * towards)).norm(), 0.02 * 30 * mm_per_pixel);
  wheel(space(), pixel(clip.free_point_mm), 2);
  EXPECT_LT((clip.free_point_mm - (start - (30 * mm_per_pixel - 2) * towards)).norm(), 0.5);
  // A disc on the ring follows the mouse on the sphere around the centre.
  trigger(Act::FaceFreePlane);
  const double radius_mm = 56 * space().map().mm_per_pixel(clip.free_point_mm);
  const Vector3d right = space().map().axis(0);
  const QPointF disc = pixel(clip.free_point_mm + radius_mm * right);
  drag(space(), disc, disc - QPointF(28, 0));
  EXPECT_LT(clip.free_normal.dot(right), -0.7) << "the right side turns to the viewer";
  EXPECT_NEAR(clip.free_normal.dot(towards), 0.5, 0.06) << "half of the radius: 60 degrees";
  EXPECT_NEAR(clip.free_normal.norm(), 1, 1e-9);
  // The arrow now lies on the screen, and the plane follows the mouse along it.
  const Vector3d before = clip.free_point_mm, normal = clip.free_normal;
  const Vector3d tip = before + radius_mm * normal;
  drag(space(), pixel(tip), pixel(tip + 6 * normal));
  EXPECT_NEAR((clip.free_point_mm - before).dot(normal), 6, 1);
  EXPECT_LT((clip.free_normal - normal).norm(), 1e-9);
  // Elsewhere, a drag rotates the camera, and the plane stays in the patient.
  const Vector3d placed = clip.free_point_mm;
  drag(space(), QPointF(40, 40), QPointF(90, 60));
  EXPECT_EQ(clip.free_point_mm, placed);
  EXPECT_GT((space().map().axis(2) - towards).norm(), 0.1);
}

TEST_F(SpaceTest, WhatIsCutAwayCannotBePicked) {
  add_sphere(centre(), 5);
  const ItemId outer = scene().meshes[0].id, inner = scene().meshes[1].id;
  const auto click = [&](const Vector3d& at, Qt::KeyboardModifiers modifiers) {
    mouse(space(), QEvent::MouseButtonPress, pixel(at), Qt::LeftButton, Qt::LeftButton, modifiers);
    mouse(space(), QEvent::MouseButtonRelease, pixel(at), Qt::LeftButton, Qt::NoButton, modifiers);
  };
  ASSERT_TRUE(bench().apply(AddPoint{outer, centre() + Vector3d(0, 0, 12), MarkKind::Boundary}));
  bench().pause();
  const ItemId point = scene().points.back().id;
  bench().view.selected_point = 0;
  click(centre() + Vector3d(0, 0, 12), {});
  EXPECT_EQ(bench().view.selected_point, point);
  bench().view.selected_point = 0;
  trigger(Act::ClipAxial);
  picture();
  click(centre() + Vector3d(0, 0, 12), {});
  EXPECT_EQ(bench().view.selected_point, 0u);
  bench().set_active_mesh(outer);
  click(centre() + Vector3d(2, 1, 0), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, inner) << "the cap of the inner sphere";
  click(centre() + Vector3d(8, -1, 0), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, outer) << "the cap of the outer sphere";
  bench().set_active_mesh(inner);
  click(centre() + Vector3d(0, 0, 11.5), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, inner) << "nothing is there";
  trigger(Act::ClipAxial);
  picture();
  click(centre() + Vector3d(0, 0, 11.5), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, outer);
}

/// Window with an anisotropic, oblique volume: a bright ball and one bright voxel on a ramp.
class SpaceVolumeTest : public SpaceTest {
 protected:
  void SetUp() override {
    SpaceTest::SetUp();
    if (IsSkipped()) return;
    VolumeGeometry geometry;
    geometry.size = {60, 44, 24};
    geometry.spacing_mm = {1, 1.4, 2.6};
    geometry.direction =
        (Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()) * Eigen::AngleAxisd(-0.2, Vector3d::UnitX()))
            .toRotationMatrix();
    geometry.origin_mm = {-70, 30, 12};
    Volume volume(geometry, VoxelType::Int16);
    ball_mm_ = geometry.world_from_index() * Vector3d(20, 15, 15);
    for (int k = 0; k < 24; ++k)
      for (int j = 0; j < 44; ++j)
        for (int i = 0; i < 60; ++i) {
          const double distance = (geometry.world_from_index() * Vector3d(i, j, k) - ball_mm_).norm();
          const double ball = 1000 * std::exp(-distance * distance / (2 * 5 * 5));
          volume.voxels<std::int16_t>()[volume.offset(i, j, k)] = static_cast<std::int16_t>(ball + 4 * i);
        }
    spike_mm_ = geometry.world_from_index() * Vector3d(45, 30, 6);
    volume.voxels<std::int16_t>()[volume.offset(45, 30, 6)] = 2000;
    Scene scene;
    scene.simulation = default_simulation_parameters();
    bench().open(std::move(scene), volume);
    QApplication::processEvents();
    bench().view.window = 1000, bench().view.level = 500;
    bench().view.show_annotations = false;
    bench().view.show_slices_3d = false;
    space().fit();
  }
  /// Largest intensity along the ray of a pixel, over the parts that lie before `last_mm` and that no plane removes; -1
  /// without voxels.
  double largest_on_ray(const QPointF& at, double last_mm = INFINITY) {
    const Volume& volume = bench().session().volume();
    const OrbitCamera::Ray ray = space().map().ray(at);
    const std::vector<ClipPlane> planes = clip_planes(bench().view.clip, bench().view.crosshair_mm);
    const double middle = (centre() - ray.origin_mm).dot(ray.direction);
    double most = -1;
    for (double mm = middle - 80; mm < std::min(middle + 80, last_mm); mm += 0.2) {
      const Vector3d p = ray.origin_mm + mm * ray.direction;
      if (volume.geometry().contains(p) && !is_clipped(planes, p)) most = std::max(most, volume.sample(p));
    }
    return most;
  }
  /// Grey value of the pixel by the definition of the projection.
  double expected(double intensity) {
    const double bright = std::clamp(intensity / 1000, 0.0, 1.0);
    return kBackground.red() * (1 - bright) + 255 * bright * bright;
  }
  /// Mean difference between the picture and the projection computed on the CPU, and share of equal pixels.
  std::pair<double, double> compare(const QImage& image, double tolerance) {
    double difference = 0;
    int all = 0, equal = 0;
    for (int y = 8; y < space().height() - 8; y += 9)
      for (int x = 8; x < space().width() - 8; x += 9) {
        const QPointF at(x + 0.5, y + 0.5);
        const double most = largest_on_ray(at);
        if (most < 0) continue;
        const double seen = image.pixelColor((QPointF(x, y) * space().devicePixelRatio()).toPoint()).red();
        difference += std::abs(seen - expected(most));
        ++all;
        equal += std::abs(seen - expected(most)) <= tolerance;
      }
    EXPECT_GT(all, 500);
    return {difference / all, static_cast<double>(equal) / all};
  }
  Vector3d ball_mm_, spike_mm_;
};

TEST_F(SpaceVolumeTest, TheMaximumProjectionEqualsThatOfTheCpu) {
  for (const bool reduced : {false, true}) {
    space().solids().set_reduced(reduced);
    bench().view.volume_mode = VolumeMode::Off;
    EXPECT_TRUE(close(colour_at(picture(), ball_mm_), kBackground)) << "nothing is shown";
    EXPECT_EQ(space().solids().volume_bytes(), 0u);
    trigger(Act::VolumeMaximum);
    ASSERT_EQ(bench().view.volume_mode, VolumeMode::Maximum);
    const QImage image = picture();
    EXPECT_GE(space().solids().volume_bytes(), 2u * 60 * 44 * 24);
    const auto [difference, equal] = compare(image, 6);
    EXPECT_LT(difference, reduced ? 2.5 : 1.5) << reduced;
    EXPECT_GT(equal, reduced ? 0.93 : 0.97) << reduced;
    EXPECT_GT(colour_at(image, ball_mm_).red(), 240);
    EXPECT_GT(colour_at(image, spike_mm_).red(), 150) << "one voxel";
    EXPECT_TRUE(close(image.pixelColor(10, 10), kBackground));
    // Another camera, window or plane is followed.
    drag(space(), QPointF(60, 60), QPointF(160, 90));
    const auto [rotated, equal_rotated] = compare(picture(), 6);
    EXPECT_GT(equal_rotated, reduced ? 0.93 : 0.97) << reduced;
    bench().view.clip.on[1] = true;
    bench().view.crosshair_mm = ball_mm_ + Vector3d(-3, 0, 0);
    const auto [cut, equal_cut] = compare(picture(), 6);
    EXPECT_GT(equal_cut, reduced ? 0.9 : 0.96) << reduced;
    bench().view.clip.on[1] = false;
    bench().view.level = 5000;
    EXPECT_TRUE(close(colour_at(picture(), ball_mm_), kBackground));
    bench().view.level = 500;
    trigger(Act::VolumeMaximum);
    EXPECT_EQ(bench().view.volume_mode, VolumeMode::Off);
    picture();
    EXPECT_EQ(space().solids().volume_bytes(), 0u) << "memory is released";
  }
}

TEST_F(SpaceVolumeTest, MeshesHideWhatIsBehindThem) {
  const Vector3d towards = space().map().axis(2);
  for (const bool reduced : {false, true}) {
    space().solids().set_reduced(reduced);
    bench().view.volume_mode = VolumeMode::Maximum;
    EXPECT_GT(colour_at(picture(), ball_mm_).red(), 240);
    // In front of the ball, a mesh hides it.
    ASSERT_TRUE(bench().apply(AddMesh{"", {ball_mm_ + 9 * towards, 3}, Colour{20, 60, 200}}));
    bench().pause();
    QColor seen = colour_at(picture(), ball_mm_);
    EXPECT_GT(seen.blue(), seen.red() + 60) << reduced;
    // A translucent one lets it through, in its colour.
    bench().view.opacity = 0.4f;
    const QColor translucent = colour_at(picture(), ball_mm_);
    EXPECT_GT(translucent.red(), seen.red() + 40) << reduced;
    EXPECT_GT(translucent.blue(), translucent.red() + 10) << reduced;
    bench().view.opacity = 1;
    // Behind the ball, the ball hides a mesh.
    ASSERT_TRUE(bench().apply(Undo{}));
    ASSERT_TRUE(bench().apply(AddMesh{"", {ball_mm_ - 14 * towards, 3}, Colour{20, 60, 200}}));
    bench().pause();
    EXPECT_GT(colour_at(picture(), ball_mm_).red(), 200) << reduced;
    ASSERT_TRUE(bench().apply(Undo{}));
  }
}

TEST_F(SpaceVolumeTest, ShadingShowsTheSurfaceOfTheBallAndPlanesCutIt) {
  space().solids().set_reduced(false);
  bench().view.window = 400, bench().view.level = 700;  // black below 500: a ball of radius 5.9 mm
  bench().view.volume_mode = VolumeMode::Shaded;
  bench().view_edited();
  const QImage image = picture();
  EXPECT_GT(colour_at(image, ball_mm_).red(), 110);
  const Vector3d right = space().map().axis(0), up = space().map().axis(1);
  EXPECT_TRUE(close(colour_at(image, ball_mm_ + 9 * right), kBackground));
  const auto lit = [&](double r, double u) { return colour_at(image, ball_mm_ + r * right + u * up).red(); };
  EXPECT_GT(lit(-2, 3), lit(2, -3) + 10) << "lit from the upper left";
  // A plane behind the ball removes it.
  bench().view.clip.on[3] = bench().view.clip.free_placed = true;
  bench().view.clip.free_normal = space().map().axis(2);
  bench().view.clip.free_point_mm = ball_mm_ - 8 * bench().view.clip.free_normal;
  EXPECT_TRUE(close(colour_at(picture(), ball_mm_), kBackground));
  bench().view.clip.flipped[3] = true;
  EXPECT_GT(colour_at(picture(), ball_mm_).red(), 110);
}

TEST_F(SpaceVolumeTest, ASoftwareRendererOffersTheMaximumOnly) {
  space().solids().set_reduced(true);
  bench().view_edited();
  EXPECT_FALSE(window_->actions()[Act::VolumeShaded]->isEnabled());
  EXPECT_TRUE(window_->actions()[Act::VolumeShaded]->toolTip().contains("graphics card"));
  EXPECT_TRUE(window_->actions()[Act::VolumeMaximum]->isEnabled());
  space().solids().set_reduced(false);
  bench().view_edited();
  EXPECT_TRUE(window_->actions()[Act::VolumeShaded]->isEnabled());
}

TEST_F(SpaceTest, PlanesAndVolumeAreRemembered) {
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, folder_.filePath("settings"));
  {
    WindowMemory memory(*window_);
    EXPECT_FALSE(bench().view.clip.any());
    bench().view.clip.on = {true, false, true, true};
    bench().view.clip.flipped = {false, false, true, false};
    bench().view.clip.image_on_caps = false;
    bench().view.volume_mode = VolumeMode::Maximum;
  }
  window_.reset();
  SpaceTest::SetUp();
  bench().view.clip = {};
  WindowMemory memory(*window_);
  EXPECT_EQ(bench().view.clip.on, (std::array{true, false, true, true}));
  EXPECT_EQ(bench().view.clip.flipped, (std::array{false, false, true, false}));
  EXPECT_FALSE(bench().view.clip.image_on_caps);
  EXPECT_EQ(bench().view.volume_mode, VolumeMode::Maximum);
  EXPECT_TRUE(window_->actions()[Act::ClipCoronal]->isChecked());
  // The free plane is placed in each volume that is opened.
  open_phantom();
  EXPECT_TRUE(bench().view.clip.free_placed);
  EXPECT_LT((bench().view.clip.free_normal - space().map().axis(2)).norm(), 1e-9);
}

TEST(ClipPlanesTest, RaysAndSegmentsKeepWhatNoPlaneRemoves) {
  ClipState state;
  EXPECT_TRUE(clip_planes(state, {0, 0, 0}).empty());
  state.on = {true, true, false, false};
  state.flipped[1] = true;
  const std::vector<ClipPlane> planes = clip_planes(state, {1, 2, 3});  // kept: z < 3 and x > 1
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_TRUE(is_clipped(planes, {2, 0, 3.1}));
  EXPECT_TRUE(is_clipped(planes, {0.9, 0, 0}));
  EXPECT_FALSE(is_clipped(planes, {1, 7, 3})) << "on the planes";
  const RayRange through = kept_range(planes, {5, 0, 10}, {-0.6, 0, -0.8});
  EXPECT_GT(through.first_mm, through.last_mm) << "x = 1 is passed before z = 3";
  const RayRange range = kept_range(planes, {13, 0, 10}, {-0.6, 0, -0.8});
  EXPECT_NEAR(range.first_mm, 8.75, 1e-9);
  EXPECT_NEAR(range.last_mm, 20, 1e-9);
  const RayRange beyond = kept_range(planes, {5, 0, 4}, {1, 0, 0});
  EXPECT_GT(beyond.first_mm, beyond.last_mm);
  const std::vector<Eigen::Vector3f> kept =
      clip_segments(planes, {{0, 0, 0}, {4, 0, 0}, {2, 0, 2}, {2, 0, 6}, {0, 0, 0}, {0, 5, 0}});
  ASSERT_EQ(kept.size(), 4u);
  EXPECT_LT((kept[0] - Eigen::Vector3f(1, 0, 0)).norm(), 1e-5f);
  EXPECT_LT((kept[1] - Eigen::Vector3f(4, 0, 0)).norm(), 1e-5f);
  EXPECT_LT((kept[2] - Eigen::Vector3f(2, 0, 2)).norm(), 1e-5f);
  EXPECT_LT((kept[3] - Eigen::Vector3f(2, 0, 3)).norm(), 1e-5f);
}

TEST(VolumeBlocksTest, ReduceToAtMostTheTexelsAndKeepMeanOrMaximum) {
  VolumeGeometry geometry;
  geometry.size = {10, 7, 3};
  geometry.spacing_mm = {1, 1, 3};
  Volume volume(geometry, VoxelType::Float32);
  for (std::size_t n = 0; n < volume.voxels<float>().size(); ++n)
    volume.voxels<float>()[n] = static_cast<float>(n % 11);
  volume.voxels<float>()[volume.offset(5, 3, 1)] = NAN;
  VolumeGeometry longer = geometry;
  longer.size[2] = 3000;
  EXPECT_EQ(choose_blocks(longer, 1'000'000).size, (std::array{10, 7, 1500})) << "longest side of a texture";
  const VolumeBlocks all = choose_blocks(geometry, 210);
  EXPECT_EQ(all.voxels, (std::array{1, 1, 1}));
  const VolumeBlocks blocks = choose_blocks(geometry, 60);
  EXPECT_EQ(blocks.voxels, (std::array{2, 2, 1})) << "as cubic as the spacing permits";
  EXPECT_EQ(blocks.size, (std::array{5, 4, 3}));
  const Volume::Range range{0, 10};
  for (const BlockValue value : {BlockValue::Mean, BlockValue::Maximum}) {
    const std::vector<std::uint16_t> values = block_values(volume, blocks, value, range, 1, 3);
    ASSERT_EQ(values.size(), 40u);
    for (int k = 1; k < 3; ++k)
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 5; ++i) {
          double sum = 0, most = 0;
          int count = 0;
          for (int y = 2 * j; y < std::min(2 * j + 2, 7); ++y)
            for (int x = 2 * i; x < 2 * i + 2; ++x, ++count) {
              const double v = volume.value(x, y, k), finite = std::isfinite(v) ? v : 0;
              sum += finite, most = std::max(most, finite);
            }
          const double expected = (value == BlockValue::Mean ? sum / count : most) / 10 * 65535;
          EXPECT_NEAR(values[static_cast<std::size_t>(((k - 1) * 4 + j) * 5 + i)], expected, 1);
        }
  }
}

}  // namespace
}  // namespace simplexseg
