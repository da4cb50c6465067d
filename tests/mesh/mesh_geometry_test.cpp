// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "mesh/mesh_geometry.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

Vector3d position(const SimplexMesh& mesh, int v) { return mesh.positions[v].cast<double>(); }

SimplexMesh make_noisy_sphere(unsigned seed, float sigma_mm, int level) {
  SimplexMesh mesh = make_sphere({30, -20, 10}, 10.0, level);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0f, sigma_mm);
  for (auto& p : mesh.positions) p += Vector3f(noise(random), noise(random), noise(random));
  return mesh;
}

/// Dodecahedron whose vertex 0 has the neighbours 1, 2, 3 at the given positions.
SimplexMesh make_fan(const Vector3f& p, const Vector3f& p1, const Vector3f& p2, const Vector3f& p3) {
  SimplexMesh mesh = make_sphere({0, 0, 0}, 1.0, 0);
  const auto n = mesh.neighbours[0];
  mesh.positions[0] = p;
  mesh.positions[n[0]] = p1;
  mesh.positions[n[1]] = p2;
  mesh.positions[n[2]] = p3;
  return mesh;
}

void expect_finite(const VertexGeometry& g) {
  EXPECT_TRUE(g.normal.allFinite());
  EXPECT_NEAR(g.normal.norm(), 1.0, 1e-12);
  EXPECT_TRUE(std::isfinite(g.elevation_mm));
  EXPECT_TRUE(g.metric.allFinite());
  EXPECT_NEAR(g.metric.sum(), 1.0, 1e-9);
  EXPECT_TRUE(std::isfinite(g.doubled_area_mm2));
  EXPECT_TRUE(std::isfinite(g.mean_curvature));
}

TEST(MeshGeometry, VertexIsItsMetricFootPlusElevation) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const SimplexMesh mesh = make_noisy_sphere(seed, 0.5f, 3);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const VertexGeometry g = vertex_geometry(mesh, v);
      const auto& n = mesh.neighbours[v];
      const Vector3d p1 = position(mesh, n[0]), p2 = position(mesh, n[1]), p3 = position(mesh, n[2]);
      const Vector3d again = g.metric[0] * p1 + g.metric[1] * p2 + g.metric[2] * p3 + g.elevation_mm * g.normal;
      const double size = 1.0 + g.metric.cwiseAbs().maxCoeff();  // error amplification of a thin triangle of neighbours
      EXPECT_LT((again - position(mesh, v)).norm(), 1e-12 * size * size * 50.0) << "seed " << seed << " vertex " << v;
      EXPECT_NEAR(g.metric.sum(), 1.0, 1e-13 * size * size);
      EXPECT_NEAR(g.normal.norm(), 1.0, 1e-14);
      EXPECT_NEAR(g.doubled_area_mm2, (p2 - p1).cross(p3 - p1).norm(), 1e-12);
    }
  }
}

TEST(MeshGeometry, SimplexAngleGivesElevationBack) {
  // Second identity of the model: h = L(r, d, phi) with sin(phi)/r = H.
  for (unsigned seed = 0; seed < 3; ++seed) {
    const SimplexMesh mesh = make_noisy_sphere(seed, 0.2f, 2);
    int checked = 0;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const VertexGeometry g = vertex_geometry(mesh, v);
      const auto& n = mesh.neighbours[v];
      const Vector3d p1 = position(mesh, n[0]), p2 = position(mesh, n[1]), p3 = position(mesh, n[2]);
      // Circumcentre from its barycentric weights a^2 (b^2 + c^2 - a^2).
      const double a = (p2 - p3).squaredNorm(), b = (p3 - p1).squaredNorm(), c = (p1 - p2).squaredNorm();
      const Vector3d w(a * (b + c - a), b * (c + a - b), c * (a + b - c));
      const Vector3d centre = (w[0] * p1 + w[1] * p2 + w[2] * p3) / w.sum();
      const double r = (p1 - centre).norm();
      const double d = (position(mesh, v) - g.elevation_mm * g.normal - centre).norm();
      const double sine = g.mean_curvature * r;
      ASSERT_LE(std::abs(sine), 1.0 + 1e-9);
      if (d > 0.95 * r || std::abs(sine) > 0.999) continue;
      // phi and pi - phi have the same sine; the elevation distinguishes a vertex above the sphere's centre from one
      // below.
      const double offset = (g.elevation_mm * g.elevation_mm + d * d - r * r) / (2.0 * g.elevation_mm);
      const bool acute = g.elevation_mm > 0.0 ? offset < 0.0 : offset > 0.0;
      const double tangent = (acute ? 1.0 : -1.0) * sine / std::sqrt(1.0 - sine * sine);
      const double k = r * r - d * d;
      const double h = k * tangent / ((acute ? 1.0 : -1.0) * std::sqrt(r * r + k * tangent * tangent) + r);
      EXPECT_NEAR(h, g.elevation_mm, 1e-8 * r) << "vertex " << v;
      ++checked;
    }
    EXPECT_GT(checked, 250);
  }
}

TEST(MeshGeometry, ElevationIsEqualAndPositiveOnADodecahedron) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10.0, 0);
  const double h = vertex_geometry(mesh, 0).elevation_mm;
  EXPECT_GT(h, 1.0);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const VertexGeometry g = vertex_geometry(mesh, v);
    EXPECT_NEAR(g.elevation_mm, h, 1e-5);
    EXPECT_NEAR(g.mean_curvature, 0.1, 1e-6);
    EXPECT_LT((g.metric - Vector3d::Constant(1.0 / 3.0)).norm(), 1e-6);
    EXPECT_GT(g.normal.dot(position(mesh, v).normalized()), 1.0 - 1e-6);
  }
}

TEST(MeshGeometry, CurvatureOfASphereIsItsReciprocalRadius) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 4.0, 4);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    ASSERT_NEAR(vertex_geometry(mesh, v).mean_curvature, 0.25, 1e-3) << "vertex " << v;
}

TEST(MeshGeometry, ADentHasNegativeElevationAndCurvature) {
  SimplexMesh mesh = make_sphere({0, 0, 0}, 4.0, 2);
  mesh.positions[9] *= 0.8f;
  const VertexGeometry g = vertex_geometry(mesh, 9);
  EXPECT_LT(g.elevation_mm, 0.0);
  EXPECT_LT(g.mean_curvature, 0.0);
}

TEST(MeshGeometry, AFlatVertexHasNoElevationNorCurvature) {
  const auto g = vertex_geometry(make_fan({0, 0, 2}, {1, 0, 2}, {-0.5f, 1, 2}, {-0.5f, -1, 2}), 0);
  expect_finite(g);
  EXPECT_EQ(g.elevation_mm, 0.0);
  EXPECT_EQ(g.mean_curvature, 0.0);
  EXPECT_EQ(g.normal, Vector3d(0, 0, 1));
  // Also on the circumcircle of its neighbours, where the sphere is undefined.
  const auto on_circle = vertex_geometry(make_fan({0, 1, 2}, {1, 0, 2}, {-1, 0, 2}, {0, -1, 2}), 0);
  expect_finite(on_circle);
  EXPECT_EQ(on_circle.mean_curvature, 0.0);
}

TEST(MeshGeometry, CollinearNeighboursGiveAFiniteOutwardNormal) {
  // The normal at vertex 0 of the dodecahedron is its own direction; the line of neighbours is orthogonal to it.
  const Vector3f up = make_sphere({0, 0, 0}, 1.0, 0).positions[0];
  const Vector3f side = up.unitOrthogonal();
  for (const Vector3f& p : {Vector3f(1.2f * up), Vector3f(0.9f * up), Vector3f(0.9f * up + 0.3f * side)}) {
    const auto mesh = make_fan(p, 0.9f * up - 0.4f * side, 0.9f * up + 0.1f * side, 0.9f * up + 0.5f * side);
    const auto g = vertex_geometry(mesh, 0);
    expect_finite(g);
    EXPECT_LT(std::abs(g.normal.dot(side.cast<double>())), 1e-6);
    EXPECT_GT(g.normal.dot(up.cast<double>()), 0.5);
    EXPECT_EQ(g.mean_curvature, 0.0);
  }
  const auto coincident = vertex_geometry(make_fan(1.2f * up, up, up, up), 0);
  expect_finite(coincident);
  EXPECT_GT(coincident.normal.dot(up.cast<double>()), 0.5);
  EXPECT_NEAR(coincident.elevation_mm, 0.2, 0.1);
  SimplexMesh point = make_sphere({0, 0, 0}, 1.0, 0);
  for (auto& p : point.positions) p = Vector3f(1, 2, 3);
  expect_finite(vertex_geometry(point, 0));
}

TEST(MeshGeometry, NearlyCollinearNeighboursStayFinite) {
  for (float offset = 1.0f; offset > 1e-30f; offset *= 0.1f)
    expect_finite(vertex_geometry(make_fan({0, 0, 1}, {-1, 0, 1}, {0.3f, offset, 1}, {1, 0, 1}), 0));
}

TEST(MeshGeometry, TessellationIsClosedAndHoldsTheVolume) {
  const SimplexMesh mesh = make_noisy_sphere(4, 0.1f, 3);
  const TriangleMesh t = tessellate(mesh);
  const CellList cells = cells_of(mesh);
  ASSERT_EQ(t.positions.size(), std::size_t(mesh.vertex_count() + cells.count()));
  ASSERT_EQ(t.triangles.size(), 3u * mesh.vertex_count());
  EXPECT_TRUE(std::equal(mesh.positions.begin(), mesh.positions.end(), t.positions.begin()));
  double volume = 0.0, area = 0.0;
  for (const auto& [a, b, c] : t.triangles) {
    const Vector3d pa = t.positions[a].cast<double>(), pb = t.positions[b].cast<double>(),
                   pc = t.positions[c].cast<double>();
    volume += pa.dot(pb.cross(pc)) / 6.0;
    area += 0.5 * (pb - pa).cross(pc - pa).norm();
  }
  const SurfaceMeasures m = measure(mesh);
  EXPECT_NEAR(volume, m.volume_mm3, 1e-5 * m.volume_mm3);
  EXPECT_NEAR(area, m.area_mm2, 1e-5 * m.area_mm2);
  EXPECT_NO_THROW(dual_of(t));  // closed and consistently oriented
}

TEST(MeshGeometry, MeasuresFollowMotionScaleAndOrientation) {
  SimplexMesh mesh = make_noisy_sphere(5, 0.1f, 3);
  const SurfaceMeasures before = measure(mesh);
  for (auto& p : mesh.positions) p = 2.0f * p + Vector3f(1000, -500, 250);
  const SurfaceMeasures after = measure(mesh);
  EXPECT_NEAR(after.volume_mm3, 8.0 * before.volume_mm3, 1e-4 * after.volume_mm3);
  EXPECT_NEAR(after.area_mm2, 4.0 * before.area_mm2, 1e-4 * after.area_mm2);
  EXPECT_NEAR(after.mean_edge_mm, 2.0 * before.mean_edge_mm, 1e-4 * after.mean_edge_mm);
  EXPECT_LT((after.centroid_mm - 2.0 * before.centroid_mm - Vector3d(1000, -500, 250)).norm(), 1e-3);
  for (auto& n : mesh.neighbours) std::swap(n[0], n[1]);
  const SurfaceMeasures turned = measure(mesh);
  EXPECT_NEAR(turned.volume_mm3, -after.volume_mm3, 1e-9 * after.volume_mm3);
  EXPECT_LT((turned.centroid_mm - after.centroid_mm).norm(), 1e-6);
}

TEST(MeshGeometry, CentroidIsThatOfTheSolid) {
  // A warp that concentrates the vertices at one end. Its moments give the centroid of the solid.
  SimplexMesh mesh = make_sphere({0, 0, 0}, 1.0, 6);
  for (auto& p : mesh.positions) p.x() += 0.5f * (p.y() * p.y() + p.z() * p.z());
  // Shear x += (y^2 + z^2)/2 keeps volumes and moves the centroid by the mean of (y^2 + z^2)/2 over the ball = 1/5.
  const SurfaceMeasures m = measure(mesh);
  EXPECT_NEAR(m.volume_mm3, 4.0 / 3.0 * std::numbers::pi, 2e-3);
  EXPECT_LT((m.centroid_mm - Vector3d(0.2, 0, 0)).norm(), 1e-3);
}

TEST(MeshGeometry, CentroidOfAFlatMeshIsTheMeanOfItsVertices) {
  SimplexMesh mesh = make_sphere({3, 4, 5}, 1.0, 2);
  for (auto& p : mesh.positions) p.z() = 5.0f;
  const SurfaceMeasures m = measure(mesh);
  EXPECT_NEAR(m.volume_mm3, 0.0, 1e-9);
  EXPECT_LT((m.centroid_mm - Vector3d(3, 4, 5)).norm(), 1e-3);
  EXPECT_EQ(measure(SimplexMesh{}).area_mm2, 0.0);
}

TEST(MeshGeometry, VertexAreasSumToTheSurface) {
  const SimplexMesh mesh = make_noisy_sphere(6, 0.2f, 3);
  const std::vector<double> areas = vertex_areas(mesh);
  const double area = measure(mesh).area_mm2;
  EXPECT_NEAR(std::accumulate(areas.begin(), areas.end(), 0.0), area, 1e-9 * area);
  // Equal on a dodecahedron, larger on a dilated patch.
  const std::vector<double> even = vertex_areas(make_sphere({0, 0, 0}, 1.0, 0));
  for (double a : even) EXPECT_NEAR(a, even[0], 1e-6);
  SimplexMesh stretched = make_sphere({0, 0, 0}, 1.0, 0);
  const double before = even[3];
  stretched.positions[3] *= 1.5f;
  EXPECT_GT(vertex_areas(stretched)[3], 1.1 * before);
}

}  // namespace
}  // namespace simplexseg
