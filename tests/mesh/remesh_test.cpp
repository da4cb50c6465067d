// SPDX-License-Identifier: Apache-2.0
#include "mesh/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "genus.h"
#include "mesh/iso_surface.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

struct Shape {
  std::array<int, 3> size;
  std::vector<float> values;  // positive inside
  TriangleMesh surface() const { return iso_surface(values, size, 0, Eigen::Affine3d::Identity()); }
  Eigen::Vector3d onto(const Eigen::Vector3d& p) const {
    return project_onto_iso_surface(values, size, 0, Eigen::Affine3d::Identity(), p);
  }
  TriangleMesh remeshed(double edge) const {
    return remesh(surface(), edge, [this](const Eigen::Vector3d& p) { return onto(p); });
  }
};
Shape shape_of(const std::array<int, 3>& size, const std::function<double(const Eigen::Vector3d&)>& f) {
  std::vector<float> values;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) values.push_back(static_cast<float>(f(Eigen::Vector3d(i, j, k))));
  return {size, values};
}
Shape ball() {
  return shape_of({30, 30, 30}, [](const Eigen::Vector3d& p) { return 10 - (p - Eigen::Vector3d(15, 14, 15)).norm(); });
}
struct Quality {
  double shortest = 1e9, longest = 0, least_angle = 180, mean = 0;
  int least_valence = 1 << 20, most_valence = 0;
};
Quality quality_of(const TriangleMesh& surface) {
  Quality q;
  std::map<int, int> valence;
  for (const auto& t : surface.triangles)
    for (int e = 0; e < 3; ++e) {
      const auto at = [&](int k) { return Eigen::Vector3d(surface.positions[t[(e + k) % 3]].cast<double>()); };
      const double length = (at(1) - at(0)).norm();
      q.shortest = std::min(q.shortest, length), q.longest = std::max(q.longest, length);
      q.mean += length / (3.0 * static_cast<double>(surface.triangles.size()));
      const double cosine = (at(1) - at(0)).normalized().dot((at(2) - at(0)).normalized());
      q.least_angle = std::min(q.least_angle, std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi);
      ++valence[t[e]];
    }
  for (const auto& [v, n] : valence)
    q.least_valence = std::min(q.least_valence, n), q.most_valence = std::max(q.most_valence, n);
  return q;
}

TEST(Remesh, MakesEdgesUniformAndValencesSix) {
  const TriangleMesh before = ball().surface();
  EXPECT_LT(quality_of(before).least_angle, 15) << "input from marching tetrahedra";
  EXPECT_GE(quality_of(before).most_valence, 8);
  for (const double edge : {0.8, 1.5, 3.0}) {
    const TriangleMesh after = ball().remeshed(edge);
    const Quality q = quality_of(after);
    EXPECT_NEAR(q.mean, edge, 0.12 * edge);
    EXPECT_GT(q.shortest, 0.5 * edge) << edge;
    EXPECT_LT(q.longest, 1.8 * edge) << edge;
    EXPECT_GT(q.least_angle, 25) << edge;
    EXPECT_GE(q.least_valence, 4) << edge;
    EXPECT_LE(q.most_valence, 7) << edge;
    const double even = std::numbers::sqrt3 / 4 * edge * edge;
    EXPECT_NEAR(area_mm2(after) / even, static_cast<double>(after.triangles.size()),
                0.25 * static_cast<double>(after.triangles.size()));
    // Vertices stay on the surface, which interpolation places slightly inside the ball.
    for (const Eigen::Vector3f& p : after.positions)
      EXPECT_NEAR((p.cast<double>() - Eigen::Vector3d(15, 14, 15)).norm(), 10, 0.1);
    const SimplexMesh mesh = dual_of(after);
    EXPECT_NO_THROW(validate(mesh));
    EXPECT_EQ(one_less_genus(mesh), 1);
  }
}

TEST(Remesh, KeepsHolesAndPartsWhateverTheEdge) {
  const Shape torus = shape_of({40, 40, 16}, [](const Eigen::Vector3d& p) {
    return 3 - std::hypot(std::hypot(p[0] - 20, p[1] - 20) - 8, p[2] - 8);
  });
  const Shape two = shape_of({40, 20, 16}, [](const Eigen::Vector3d& p) {
    return 5 - std::min((p - Eigen::Vector3d(8, 8, 8)).norm(), (p - Eigen::Vector3d(30, 8, 8)).norm());
  });
  for (const double edge : {0.7, 2.0, 6.0, 50.0}) {
    const SimplexMesh ring = dual_of(torus.remeshed(edge)), parts = dual_of(two.remeshed(edge));
    EXPECT_NO_THROW(validate(ring)) << edge;
    EXPECT_NO_THROW(validate(parts)) << edge;
    EXPECT_EQ(one_less_genus(ring), 0) << edge;
    EXPECT_EQ(one_less_genus(parts), 2) << edge;
  }
}

TEST(Remesh, KeepsAThinRod) {
  const Shape rod = shape_of({40, 9, 9}, [](const Eigen::Vector3d& p) {
    return p[0] < 4 || p[0] > 36 ? -1 : 1.2 - std::hypot(p[1] - 4, p[2] - 4);
  });
  const SurfaceMeasures before = measure(dual_of(rod.surface()));
  const SimplexMesh mesh = dual_of(rod.remeshed(0.8));
  EXPECT_NO_THROW(validate(mesh));
  EXPECT_EQ(one_less_genus(mesh), 1);
  EXPECT_NEAR(measure(mesh).volume_mm3, before.volume_mm3, 0.25 * before.volume_mm3);
}

TEST(Remesh, ProjectionReachesTheSurfaceAndIgnoresPositionsOutsideTheGrid) {
  const Shape shape = ball();
  for (const double r : {8.8, 9.6, 10.0, 10.7}) {
    const Eigen::Vector3d way = Eigen::Vector3d(1, 2, -0.5).normalized(), centre(15, 14, 15);
    EXPECT_NEAR((shape.onto(centre + r * way) - centre).norm(), 10, r < 9 ? 0.25 : 0.03)
        << "at most a cell in two steps";
  }
  EXPECT_EQ(shape.onto({-3, 5, 5}), Eigen::Vector3d(-3, 5, 5));
  Eigen::Affine3d turned = Eigen::Affine3d::Identity();
  turned.linear() << 0, -0.5, 0, 2, 0, 0, 0, 0, 1;
  turned.translation() << 4, 5, 6;
  const Eigen::Vector3d at = turned * Eigen::Vector3d(15, 14, 25.4);
  const Eigen::Vector3d onto = turned.inverse() * project_onto_iso_surface(shape.values, shape.size, 0, turned, at);
  EXPECT_NEAR((onto - Eigen::Vector3d(15, 14, 15)).norm(), 10, 0.03);
}

TEST(Remesh, OfNoiseIsStillASurface) {
  std::vector<float> noise(4000);
  unsigned state = 1;
  for (float& x : noise) x = static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) / (1 << 24);
  for (float& x : noise) x -= 0.6f;
  const Shape shape{{20, 20, 10}, noise};
  const int genus = one_less_genus(dual_of(shape.surface()));
  for (const double edge : {0.5, 1.0, 2.0}) {
    const SimplexMesh mesh = dual_of(shape.remeshed(edge));
    EXPECT_NO_THROW(validate(mesh)) << edge;
    EXPECT_EQ(one_less_genus(mesh), genus) << edge;
  }
}

}  // namespace
}  // namespace simplexseg
