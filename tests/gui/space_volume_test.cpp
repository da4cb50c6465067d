// SPDX-License-Identifier: Apache-2.0
// Volume rendering in the 3D view: tests send events and check pixels.
#include <cmath>

#include "space_fixture.h"

namespace simplexseg {
namespace {

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
    press(Act::VolumeMaximum);
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
    press(Act::VolumeMaximum);
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

}  // namespace
}  // namespace simplexseg
