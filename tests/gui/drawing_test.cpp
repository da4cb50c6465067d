// SPDX-License-Identifier: Apache-2.0
// What the views draw, as far as it is computed without OpenGL.
#include <gtest/gtest.h>

#include <map>

#include "core/phantom.h"
#include "core/session.h"
#include "gpu/backend.h"
#include "gui/camera.h"
#include "gui/slice_view.h"
#include "gui/surfaces.h"

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

TEST(Surfaces, NormalsPointOutwardsAndFollowThePose) {
  const auto session = session_with_sphere(10);
  Surfaces surfaces;
  surfaces.update(*session);
  ASSERT_EQ(surfaces.all().size(), 1u);
  const Surface& surface = surfaces.all()[0];
  EXPECT_EQ(surface.triangles.size(), 3 * session->scene().meshes[0].mesh.neighbours.size());
  for (std::size_t p = 0; p < surface.points_mm.size(); ++p) {
    EXPECT_GT(surface.normals[p].dot((surface.points_mm[p] - kCentre.cast<float>()).normalized()), 0.95f);
  }
  const std::uint64_t topology = surface.topology_stamp;
  session->apply(EditMesh{session->scene().meshes[0].id, {}, Colour{1, 2, 3}, {}, {}});
  surfaces.update(*session);
  EXPECT_EQ(surfaces.all()[0].topology_stamp, topology);
  EXPECT_EQ(surfaces.all()[0].colour, (Colour{1, 2, 3}));
  session->apply(RefineMesh{session->scene().meshes[0].id});
  surfaces.update(*session);
  EXPECT_NE(surfaces.all()[0].topology_stamp, topology);
  EXPECT_EQ(surfaces.all()[0].triangles.size(), 3 * session->scene().meshes[0].mesh.neighbours.size());
}

TEST(Surfaces, APlaneCutsASphereInOneClosedCircle) {
  const auto session = session_with_sphere(10);
  Surfaces surfaces;
  surfaces.update(*session);
  for (int axis = 0; axis < 3; ++axis) {
    const float plane = static_cast<float>(kCentre[axis]) + 6;
    std::vector<Eigen::Vector3f> ends;
    cut_surface(surfaces.all()[0], axis, plane, ends);
    ASSERT_GT(ends.size(), 20u);
    std::map<std::array<int, 3>, int> meetings;
    for (const Eigen::Vector3f& end : ends) {
      EXPECT_NEAR(end[axis], plane, 1e-4);
      Eigen::Vector3d radial = end.cast<double>() - kCentre;
      radial[axis] = 0;
      EXPECT_NEAR(radial.norm(), 8, 0.35);  // sqrt(10^2 - 6^2), less the polyhedron's sagitta
      ++meetings[{static_cast<int>(std::lround(end[0] * 1e3)), static_cast<int>(std::lround(end[1] * 1e3)),
                  static_cast<int>(std::lround(end[2] * 1e3))}];
    }
    for (const auto& [place, count] : meetings) EXPECT_EQ(count % 2, 0);
    cut_surface(surfaces.all()[0], axis, static_cast<float>(kCentre[axis]) + 11, ends);
    EXPECT_TRUE(ends.empty());
  }
}

TEST(Surfaces, ARayHitsTheNearSide) {
  const auto session = session_with_sphere(10);
  Surfaces surfaces;
  surfaces.update(*session);
  const auto hit = hit_surface(surfaces.all()[0], kCentre - Eigen::Vector3d(50, 0, 0), {1, 0, 0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(*hit, 40, 0.3);
  EXPECT_FALSE(hit_surface(surfaces.all()[0], kCentre + Eigen::Vector3d(0, 20, -50), {0, 0, 1}));
}

TEST(Handles, FadeWithTheDistanceToTheSlice) {
  EXPECT_DOUBLE_EQ(handle_opacity(0), 1);
  EXPECT_GT(handle_opacity(2), handle_opacity(6));
  EXPECT_EQ(handle_opacity(40), 0);
}

TEST(OrbitCamera, LooksFromTheFrontWithTheHeadUp) {
  OrbitCamera camera;
  camera.fit(kCentre, 100);
  const Eigen::Matrix4d eye = camera.eye_from_world();
  const auto at = [&](const Eigen::Vector3d& offset) { return (eye * (kCentre + offset).homogeneous()).eval(); };
  EXPECT_GT(at({0, 0, 50}).y(), at({0, 0, -50}).y());  // superior up
  EXPECT_GT(at({50, 0, 0}).x(), at({-50, 0, 0}).x());  // the patient's left on the right
  EXPECT_GT(at({0, -50, 0}).z(), at({0, 50, 0}).z());  // anterior nearer
  // A ray through the middle meets the target.
  const OrbitCamera::Ray ray = camera.ray(0, 0, 1.5);
  const Eigen::Vector3d to = kCentre - ray.origin_mm;
  EXPECT_LT((to - to.dot(ray.direction) * ray.direction).norm(), 1e-9);
  // And one through any place of the picture projects back to it.
  const OrbitCamera::Ray side = camera.ray(0.4, -0.7, 1.5);
  const Eigen::Vector4d clip = camera.clip_from_eye(1.5) * eye * (side.origin_mm + 300 * side.direction).homogeneous();
  EXPECT_NEAR(clip.x() / clip.w(), 0.4, 1e-9);
  EXPECT_NEAR(clip.y() / clip.w(), -0.7, 1e-9);
}

}  // namespace
}  // namespace simplexseg
