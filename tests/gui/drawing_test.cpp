// SPDX-License-Identifier: Apache-2.0
// Computations of the views without OpenGL: surfaces, frame statistics, handles, camera.
#include <gtest/gtest.h>

#include <map>

#include "gpu/backend.h"
#include "gui/views/orbit_camera.h"
#include "gui/views/picking.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/frame_statistics.h"
#include "session/session.h"
#include "step/simulation_parameters.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

const Eigen::Vector3d kCentre(1, -2, 3);

std::unique_ptr<Session> session_with_sphere(double radius_mm) {
  auto session = std::make_unique<Session>(make_cpu_engine(1));
  Scene scene;
  scene.simulation = default_simulation_parameters();
  session->open(scene, make_phantom("sphere", {}).image);
  session->apply(AddMesh{"ball", Seed{kCentre, radius_mm}, {}, 0});
  return session;
}

TEST(Surfaces, OnlyVisibleMeshesAreHit) {
  const auto session = session_with_sphere(10);
  session->apply(AddMesh{"other", Seed{kCentre, 5}, {}, 0});
  ASSERT_EQ(visible_surfaces(session->scene()).size(), 2u);
  const ItemId first = session->scene().meshes[0].id;
  session->apply(EditMesh{first, {}, {}, false, {}});
  const std::vector<Surface> surfaces = visible_surfaces(session->scene());
  ASSERT_EQ(surfaces.size(), 1u);
  EXPECT_NE(surfaces[0].mesh, first);
  EXPECT_EQ(surfaces[0].shape.triangles.size(), 3 * session->scene().meshes[1].mesh.neighbours.size());
}

TEST(Surfaces, APlaneCutsASphereInOneClosedCircle) {
  const auto session = session_with_sphere(10);
  const std::vector<Surface> surfaces = visible_surfaces(session->scene());
  for (int axis = 0; axis < 3; ++axis) {
    const float plane = static_cast<float>(kCentre[axis]) + 6;
    const std::vector<Eigen::Vector3f> ends = cut_surface(surfaces[0].shape, axis, plane);
    ASSERT_GT(ends.size(), 20u);
    std::map<std::array<int, 3>, int> end_counts;
    for (const Eigen::Vector3f& end : ends) {
      EXPECT_NEAR(end[axis], plane, 1e-4);
      Eigen::Vector3d radial = end.cast<double>() - kCentre;
      radial[axis] = 0;
      EXPECT_NEAR(radial.norm(), 8, 0.35);  // sqrt(10^2 - 6^2), less the polyhedron's sagitta
      ++end_counts[{static_cast<int>(std::lround(end[0] * 1e3)), static_cast<int>(std::lround(end[1] * 1e3)),
                    static_cast<int>(std::lround(end[2] * 1e3))}];
    }
    for (const auto& [place, count] : end_counts) EXPECT_EQ(count % 2, 0);
    EXPECT_TRUE(cut_surface(surfaces[0].shape, axis, static_cast<float>(kCentre[axis]) + 11).empty());
  }
}

TEST(Surfaces, ARayHitsTheNearSide) {
  const auto session = session_with_sphere(10);
  const TriangleMesh shape = visible_surfaces(session->scene())[0].shape;
  const auto hit = hit_surface(shape, kCentre - Eigen::Vector3d(50, 0, 0), {1, 0, 0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(*hit, 40, 0.3);
  EXPECT_FALSE(hit_surface(shape, kCentre + Eigen::Vector3d(0, 20, -50), {0, 0, 1}));
}

TEST(FrameStatistics, LatencyEndsWithTheImageThatShowsTheMove) {
  FrameStatistics statistics;
  statistics.start_recording();
  statistics.painted();
  EXPECT_TRUE(statistics.shown(1.00));
  EXPECT_FALSE(statistics.shown(1.01));  // another view of the same image
  statistics.painted();
  statistics.point_moved(1.02);  // after painting: not in that image
  statistics.shown(1.03);
  statistics.painted();  // shows the point, before any step includes it
  statistics.shown(1.05);
  statistics.steps_done(7, 0.001);
  statistics.painted();
  statistics.shown(1.09);
  const FrameStatistics::Record record = statistics.stop_recording();
  ASSERT_EQ(record.frame_s.size(), 3u);
  EXPECT_NEAR(record.frame_s[2], 0.04, 1e-9);
  ASSERT_EQ(record.latency_s.size(), 1u);
  EXPECT_NEAR(record.latency_s[0], 0.03, 1e-9);
  ASSERT_EQ(record.response_s.size(), 1u);
  EXPECT_NEAR(record.response_s[0], 0.07, 1e-9);
  EXPECT_EQ(record.steps, 7);
}

TEST(FrameStatistics, APauseIsNotCountedAsAFrame) {
  FrameStatistics statistics;
  for (const double at : {1.0, 1.02, 1.04}) {
    statistics.painted();
    statistics.shown(at);
  }
  statistics.interrupt();
  statistics.painted();
  statistics.shown(60);
  EXPECT_NEAR(statistics.frames_per_second(), 50, 1e-6);
}

TEST(FrameStatistics, PercentilesAreNearestRanks) {
  EXPECT_EQ(percentile({}, 0.5), 0);
  EXPECT_EQ(percentile({3, 1, 2}, 0.5), 2);
  std::vector<double> hundred;
  for (int n = 100; n >= 1; --n) hundred.push_back(n);
  EXPECT_EQ(percentile(hundred, 0.99), 99);
  EXPECT_EQ(percentile(hundred, 1), 100);
}

TEST(Handles, FadeWithTheDistanceToTheSlice) {
  EXPECT_DOUBLE_EQ(handle_opacity(0), 1);
  EXPECT_GT(handle_opacity(2), handle_opacity(6));
  EXPECT_EQ(handle_opacity(40), 0);
}

TEST(OrbitCamera, ViewsFromTheFrontWithTheHeadUp) {
  OrbitCamera camera;
  camera.fit(kCentre, 100);
  const Eigen::Matrix4d eye = camera.eye_from_world();
  const auto at = [&](const Eigen::Vector3d& offset) { return (eye * (kCentre + offset).homogeneous()).eval(); };
  EXPECT_GT(at({0, 0, 50}).y(), at({0, 0, -50}).y());  // superior is up
  EXPECT_GT(at({50, 0, 0}).x(), at({-50, 0, 0}).x());  // the patient's left on the right
  EXPECT_GT(at({0, -50, 0}).z(), at({0, 50, 0}).z());  // anterior nearer
  // A ray through the centre hits the target.
  const OrbitCamera::Ray ray = camera.ray(0, 0, 1.5);
  const Eigen::Vector3d to = kCentre - ray.origin_mm;
  EXPECT_LT((to - to.dot(ray.direction) * ray.direction).norm(), 1e-9);
  // A ray through any point of the image projects back to it.
  const OrbitCamera::Ray side = camera.ray(0.4, -0.7, 1.5);
  const Eigen::Vector4d clip = camera.clip_from_eye(1.5) * eye * (side.origin_mm + 300 * side.direction).homogeneous();
  EXPECT_NEAR(clip.x() / clip.w(), 0.4, 1e-9);
  EXPECT_NEAR(clip.y() / clip.w(), -0.7, 1e-9);
}

}  // namespace
}  // namespace simplexseg
