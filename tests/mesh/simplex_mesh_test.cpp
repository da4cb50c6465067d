// SPDX-License-Identifier: Apache-2.0
#include "mesh/simplex_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include "core/error.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Torus around z, triangulated as a grid of halved quadrangles.
TriangleMesh make_torus(double ring_mm, double tube_mm, int around, int across) {
  TriangleMesh t;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, w = 2 * std::numbers::pi * j / across;
      const double rho = ring_mm + tube_mm * std::cos(w);
      t.positions.push_back(Vector3d(rho * std::cos(u), rho * std::sin(u), tube_mm * std::sin(w)).cast<float>());
    }
  }
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const int a = i * across + j, b = (i + 1) % around * across + j;
      const int c = (i + 1) % around * across + (j + 1) % across, d = i * across + (j + 1) % across;
      t.triangles.push_back({a, b, c});
      t.triangles.push_back({a, c, d});
    }
  }
  return t;
}

TriangleMesh make_tetrahedron() {
  return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

/// Message of the Error that `call` throws; empty without one.
std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

::testing::AssertionResult mentions(const std::string& message, const std::string& part) {
  if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\"" << message << "\" lacks \"" << part << "\"";
}

double ball_volume(double radius) { return 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3); }

/// Checks that all normals of a mesh on a ball around the origin point outwards.
void expect_outward_normals(const SimplexMesh& mesh, const Vector3d& centre, double least_cosine) {
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3d radial = (mesh.positions[v].cast<double>() - centre).normalized();
    ASSERT_GT(vertex_geometry(mesh, v).normal.dot(radial), least_cosine) << "vertex " << v;
  }
}

TEST(SimplexMesh, SphereHasTheCountsOfTheIcosahedronsDual) {
  const Vector3d centre(10, -20, 30);
  int vertices = 20;
  for (int level = 0; level <= 5; ++level, vertices *= 4) {
    const SimplexMesh mesh = make_sphere(centre, 7.0, level);
    ASSERT_EQ(mesh.vertex_count(), vertices);
    EXPECT_NO_THROW(validate(mesh));
    const CellList cells = cells_of(mesh);
    EXPECT_EQ(cells.count(), vertices / 2 + 2);
    std::map<std::size_t, int> sizes;
    for (int c = 0; c < cells.count(); ++c) ++sizes[cells[c].size()];
    EXPECT_EQ(sizes[5], 12);
    EXPECT_EQ(sizes[6], cells.count() - 12);
    for (const auto& p : mesh.positions) ASSERT_NEAR((p.cast<double>() - centre).norm(), 7.0, 1e-5);
    expect_outward_normals(mesh, centre, 0.97);
  }
}

TEST(SimplexMesh, SphereVolumeAndAreaTendToTheBalls) {
  double previous_volume = 1.0, previous_area = 1.0;
  for (int level = 1; level <= 6; ++level) {
    const SurfaceMeasures m = measure(make_sphere({5, 6, 7}, 3.0, level));
    const double volume = std::abs(m.volume_mm3 / ball_volume(3.0) - 1.0);
    const double area = std::abs(m.area_mm2 / (36.0 * std::numbers::pi) - 1.0);
    EXPECT_LT(volume, 0.35 * previous_volume) << "level " << level;
    EXPECT_LT(area, 0.35 * previous_area) << "level " << level;
    previous_volume = volume;
    previous_area = area;
  }
  EXPECT_LT(previous_volume, 3e-4);
  EXPECT_LT(previous_area, 3e-4);
}

TEST(SimplexMesh, LargeSphereIsValidAndLocal) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 100.0, 8);
  ASSERT_EQ(mesh.vertex_count(), 1310720);
  EXPECT_NO_THROW(validate(mesh));
  int near = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int w : mesh.neighbours[v]) near += std::abs(v - w) < 64;
  EXPECT_GT(near, 0.85 * 3 * mesh.vertex_count());
}

TEST(SimplexMesh, EllipsoidLiesOnItsSurface) {
  const Vector3d centre(1, 2, 3), radii(4, 10, 7);
  const SimplexMesh mesh = make_ellipsoid(centre, radii, 4);
  EXPECT_NO_THROW(validate(mesh));
  for (const auto& p : mesh.positions) ASSERT_NEAR((p.cast<double>() - centre).cwiseQuotient(radii).norm(), 1.0, 1e-5);
  const SurfaceMeasures m = measure(mesh);
  EXPECT_NEAR(m.volume_mm3, 4.0 / 3.0 * std::numbers::pi * radii.prod(), 0.01 * m.volume_mm3);
  EXPECT_LT((m.centroid_mm - centre).norm(), 1e-4);
}

TEST(SimplexMesh, SphereRejectsBadParameters) {
  EXPECT_THROW(make_sphere({0, 0, 0}, 0.0, 2), Error);
  EXPECT_THROW(make_sphere({0, 0, 0}, -1.0, 2), Error);
  EXPECT_THROW(make_sphere({0, 0, 0}, std::nan(""), 2), Error);
  EXPECT_THROW(make_sphere({0, std::nan(""), 0}, 1.0, 2), Error);
  EXPECT_THROW(make_sphere({0, 0, 0}, 1.0, -1), Error);
  EXPECT_THROW(make_sphere({0, 0, 0}, 1.0, 40), Error);
  EXPECT_THROW(make_ellipsoid({0, 0, 0}, {1, 1, 0}, 1), Error);
}

TEST(SimplexMesh, SphereLevelForReturnsTheSmallestLevel) {
  EXPECT_EQ(sphere_level_for(-5), 0);
  EXPECT_EQ(sphere_level_for(20), 0);
  EXPECT_EQ(sphere_level_for(21), 1);
  EXPECT_EQ(sphere_level_for(80), 1);
  EXPECT_EQ(sphere_level_for(1281), 4);
  EXPECT_EQ(sphere_level_for(81920), 6);
  EXPECT_EQ(sphere_level_for(1000000), 8);
}

TEST(SimplexMesh, CellsAreOrderedAndCounterClockwise) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 1.0, 2);
  const CellList cells = cells_of(mesh);
  EXPECT_EQ(cells.vertices.size(), 3u * mesh.vertex_count());
  int previous_first = 0;
  for (int c = 0; c < cells.count(); ++c) {
    const auto cell = cells[c];
    EXPECT_EQ(cell[0], *std::min_element(cell.begin(), cell.end()));
    EXPECT_GE(cell[0], previous_first);
    previous_first = cell[0];
    Vector3f normal = Vector3f::Zero(), centre = Vector3f::Zero();
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const int a = cell[i], b = cell[(i + 1) % cell.size()];
      EXPECT_EQ(std::count(mesh.neighbours[a].begin(), mesh.neighbours[a].end(), b), 1);
      normal += mesh.positions[a].cross(mesh.positions[b]);
      centre += mesh.positions[a];
    }
    EXPECT_GT(normal.normalized().dot(centre.normalized()), 0.99f);
  }
  // Ties: the first cell starts at slot 0 of vertex 0, the second at slot 1.
  EXPECT_EQ(cells[0][1], mesh.neighbours[0][0]);
  EXPECT_EQ(cells[1][1], mesh.neighbours[0][1]);
  EXPECT_EQ(cells[2][1], mesh.neighbours[0][2]);
}

TEST(SimplexMesh, CellsOfBrokenNeighboursThrow) {
  SimplexMesh mesh = make_sphere({0, 0, 0}, 1.0, 1);
  mesh.neighbours[7][1] = 80;
  EXPECT_THROW(cells_of(mesh), Error);
  mesh.neighbours[7][1] = -1;
  EXPECT_THROW(cells_of(mesh), Error);
  mesh.neighbours[7][1] = mesh.neighbours[7][0];
  EXPECT_THROW(cells_of(mesh), Error);
}

TEST(SimplexMesh, DualOfTetrahedronIsTheSmallestMesh) {
  const SimplexMesh mesh = dual_of(make_tetrahedron());
  EXPECT_EQ(mesh.vertex_count(), 4);
  EXPECT_NO_THROW(validate(mesh));
  EXPECT_EQ(cells_of(mesh).count(), 4);
}

TEST(SimplexMesh, DualTakesCentroidsAndTheTrianglesAcrossEachEdge) {
  const TriangleMesh torus = make_torus(10, 3, 24, 12);
  const SimplexMesh mesh = dual_of(torus);
  ASSERT_EQ(mesh.vertex_count(), 2 * 24 * 12);
  EXPECT_NO_THROW(validate(mesh));
  EXPECT_EQ(cells_of(mesh).count(), mesh.vertex_count() / 2);  // genus 1
  for (int t = 0; t < mesh.vertex_count(); ++t) {
    const auto& corner = torus.triangles[t];
    const Vector3f centroid =
        (torus.positions[corner[0]] + torus.positions[corner[1]] + torus.positions[corner[2]]) / 3.0f;
    EXPECT_LT((mesh.positions[t] - centroid).norm(), 1e-5f);
    for (int s = 0; s < 3; ++s) {
      const auto& other = torus.triangles[mesh.neighbours[t][s]];
      EXPECT_EQ(std::count(other.begin(), other.end(), corner[s]), 1);
      EXPECT_EQ(std::count(other.begin(), other.end(), corner[(s + 1) % 3]), 1);
    }
  }
}

TEST(SimplexMesh, DualOfTessellationIsAMeshAgain) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 5.0, 3);
  const SimplexMesh dual = dual_of(tessellate(mesh));
  EXPECT_EQ(dual.vertex_count(), 3 * mesh.vertex_count());
  EXPECT_NO_THROW(validate(dual));
}

TEST(SimplexMesh, DualRejectsTriangulationsThatAreNoClosedOrientedManifold) {
  TriangleMesh open = make_tetrahedron();
  open.triangles.pop_back();
  EXPECT_TRUE(mentions(error_of([&] { dual_of(open); }), "1 triangle"));
  TriangleMesh thrice = make_tetrahedron();
  thrice.positions.push_back({3, 3, 3});
  thrice.triangles.push_back({0, 1, 4});
  EXPECT_TRUE(mentions(error_of([&] { dual_of(thrice); }), "edge 0-1"));
  TriangleMesh turned = make_tetrahedron();
  std::swap(turned.triangles[1][0], turned.triangles[1][1]);
  EXPECT_TRUE(mentions(error_of([&] { dual_of(turned); }), "opposite orientations"));
  TriangleMesh range = make_tetrahedron();
  range.triangles[2][1] = 4;
  EXPECT_TRUE(mentions(error_of([&] { dual_of(range); }), "triangle 2"));
  TriangleMesh degenerate = make_tetrahedron();
  degenerate.triangles[3] = {1, 1, 2};
  EXPECT_TRUE(mentions(error_of([&] { dual_of(degenerate); }), "triangle 3"));
  EXPECT_TRUE(mentions(error_of([&] {
                         dual_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}});
                       }),
                       "shares two edges"));
  EXPECT_THROW(dual_of(TriangleMesh{}), Error);
}

TEST(SimplexMesh, ValidateNamesTheFirstBrokenVertex) {
  const SimplexMesh good = make_sphere({0, 0, 0}, 1.0, 2);
  ASSERT_NO_THROW(validate(good));
  const auto message_after = [&](const std::function<void(SimplexMesh&)>& damage) {
    SimplexMesh mesh = good;
    damage(mesh);
    return error_of([&] { validate(mesh); });
  };
  EXPECT_TRUE(mentions(error_of([] { validate(SimplexMesh{}); }), "0 vertices"));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) {
                         m.positions.pop_back();
                         m.neighbours.pop_back();
                       }),
                       "319 vertices"));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) { m.neighbours.pop_back(); }), "neighbours for 319 vertices"));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) { m.neighbours[0][2] = 320; }), "vertex 0 "));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) { m.neighbours[0][2] = -1; }), "vertex 0 "));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) { m.neighbours[0][2] = 0; }), "own neighbour"));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) { m.neighbours[0][2] = m.neighbours[0][1]; }), "twice"));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) { m.neighbours[0][2] = 200; }), "neighbour 200"));
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    EXPECT_TRUE(mentions(message_after([&](SimplexMesh& m) { m.positions[123].y() = bad; }), "vertex 123 "));
  for (int v : {0, 57, 319})
    EXPECT_TRUE(mentions(message_after([&](SimplexMesh& m) { std::swap(m.neighbours[v][0], m.neighbours[v][1]); }),
                         "vertex " + std::to_string(v) + " "));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) {
                         for (auto& n : m.neighbours) std::swap(n[0], n[1]);
                       }),
                       "volume of -"));
  EXPECT_TRUE(mentions(message_after([](SimplexMesh& m) {
                         for (auto& p : m.positions) p.z() = 0.0f;
                       }),
                       "volume"));
}

TEST(SimplexMesh, ValidateAcceptsSeveralParts) {
  SimplexMesh mesh = make_sphere({0, 0, 0}, 1.0, 1);
  const SimplexMesh torus = dual_of(make_torus(10, 3, 12, 8));
  const int shift = mesh.vertex_count();
  for (int v = 0; v < torus.vertex_count(); ++v) {
    mesh.positions.push_back(torus.positions[v]);
    const auto& n = torus.neighbours[v];
    mesh.neighbours.push_back({n[0] + shift, n[1] + shift, n[2] + shift});
  }
  EXPECT_NO_THROW(validate(mesh));
  EXPECT_EQ(cells_of(mesh).count(), mesh.vertex_count() / 2 + 2);
}

/// Checks the invariants of a refinement.
void expect_refinement_of(const SimplexMesh& coarse, const Refined& fine) {
  ASSERT_EQ(fine.mesh.vertex_count(), 4 * coarse.vertex_count());
  ASSERT_EQ(fine.parent.size(), fine.mesh.positions.size());
  ASSERT_NO_THROW(validate(fine.mesh));
  EXPECT_EQ(cells_of(fine.mesh).count(), cells_of(coarse).count() + 3 * coarse.vertex_count() / 2);
  for (int v = 0; v < fine.mesh.vertex_count(); ++v) {
    if (v < coarse.vertex_count()) {
      EXPECT_EQ(fine.parent[v], v);
      EXPECT_EQ(fine.mesh.positions[v], coarse.positions[v]);
    } else {
      const auto& n = fine.mesh.neighbours[fine.parent[v]];
      EXPECT_EQ(std::count(n.begin(), n.end(), v), 1);
    }
  }
}

TEST(SimplexMesh, RefinedSphereStaysOnTheSphere) {
  const Vector3d centre(20, 30, -40);
  for (int level = 0; level <= 3; ++level) {
    const SimplexMesh coarse = make_sphere(centre, 10.0, level);
    const Refined once = refine(coarse);
    expect_refinement_of(coarse, once);
    const Refined twice = refine(once.mesh);
    expect_refinement_of(once.mesh, twice);
    double previous = std::abs(measure(coarse).volume_mm3 - ball_volume(10.0));
    for (const SimplexMesh* mesh : {&once.mesh, &twice.mesh}) {
      const SurfaceMeasures m = measure(*mesh);
      const double edge = m.mean_edge_mm;
      for (const auto& p : mesh->positions)
        ASSERT_NEAR((p.cast<double>() - centre).norm(), 10.0, 2e-5 + 1e-3 * edge) << "level " << level;
      const double error = std::abs(m.volume_mm3 - ball_volume(10.0));
      EXPECT_LT(error, 0.35 * previous) << "level " << level;
      previous = error;
      expect_outward_normals(*mesh, centre, 0.9);
    }
  }
}

TEST(SimplexMesh, RefinementOfAnUnevenSphereStaysOnTheSphere) {
  SimplexMesh coarse = make_sphere({0, 0, 0}, 10.0, 3);
  const double edge = measure(coarse).mean_edge_mm;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.2 * edge, 0.2 * edge);
  for (auto& p : coarse.positions) {
    const Vector3d moved = p.cast<double>() + Vector3d(shift(random), shift(random), shift(random));
    p = (10.0 * moved.normalized()).cast<float>();
  }
  const Refined fine = refine(coarse);
  expect_refinement_of(coarse, fine);
  for (const auto& p : fine.mesh.positions) EXPECT_NEAR(p.cast<double>().norm(), 10.0, 0.01 * edge);
}

TEST(SimplexMesh, RefinedEllipsoidAndTorusComeNearerToTheirVolumes) {
  const double torus_volume = 2.0 * std::numbers::pi * std::numbers::pi * 10.0 * 9.0;
  const double ellipsoid_volume = 4.0 / 3.0 * std::numbers::pi * 5.0 * 8.0 * 20.0;
  // The dual's vertices lie inside the torus and are projected onto it before refining.
  SimplexMesh torus = dual_of(make_torus(10, 3, 24, 12));
  for (auto& p : torus.positions) {
    const Vector3d x = p.cast<double>();
    const Vector3d ring = 10.0 * Vector3d(x.x(), x.y(), 0).normalized();
    p = (ring + 3.0 * (x - ring).normalized()).cast<float>();
  }
  const std::pair<SimplexMesh, double> cases[] = {{make_ellipsoid({1, 2, 3}, {5, 8, 20}, 2), ellipsoid_volume},
                                                  {torus, torus_volume}};
  for (const auto& [coarse, volume] : cases) {
    const Refined once = refine(coarse);
    expect_refinement_of(coarse, once);
    const Refined twice = refine(once.mesh);
    expect_refinement_of(once.mesh, twice);
    const double before = std::abs(measure(coarse).volume_mm3 - volume);
    const double after_one = std::abs(measure(once.mesh).volume_mm3 - volume);
    const double after_two = std::abs(measure(twice.mesh).volume_mm3 - volume);
    EXPECT_LT(after_one, 0.5 * before);
    EXPECT_LT(after_two, after_one);
  }
  for (const auto& p : refine(torus).mesh.positions)
    EXPECT_NEAR(std::hypot(std::hypot(p.x(), p.y()) - 10.0, p.z()), 3.0, 0.05);
}

TEST(SimplexMesh, RefinementKeepsCurvature) {
  const SimplexMesh fine = refine(refine(make_sphere({0, 0, 0}, 10.0, 3)).mesh).mesh;
  for (int v = 0; v < fine.vertex_count(); ++v) {
    const double curvature = vertex_geometry(fine, v).mean_curvature;
    ASSERT_NEAR(curvature, 0.1, 0.01) << "vertex " << v;
  }
}

TEST(SimplexMesh, RefinementSurvivesNoiseAndCollapse) {
  SimplexMesh noisy = make_sphere({0, 0, 0}, 10.0, 3);
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0f, 0.3f);
  for (auto& p : noisy.positions) p += Vector3f(noise(random), noise(random), noise(random));
  const Refined fine = refine(noisy);
  expect_refinement_of(noisy, fine);
  EXPECT_NEAR(measure(fine.mesh).volume_mm3 / measure(noisy).volume_mm3, 1.0, 0.05);
  SimplexMesh collapsed = make_sphere({0, 0, 0}, 10.0, 1);
  for (auto& p : collapsed.positions) p = Vector3f(1, 2, 3);
  for (const auto& p : refine(collapsed).mesh.positions) EXPECT_EQ(p, Vector3f(1, 2, 3));
}

TEST(SimplexMesh, LargeRefinementIsValid) {
  const SimplexMesh coarse = make_sphere({0, 0, 0}, 100.0, 7);
  const Refined fine = refine(coarse);
  ASSERT_EQ(fine.mesh.vertex_count(), 4 * 327680);
  EXPECT_NO_THROW(validate(fine.mesh));
}

TEST(SimplexMesh, NeighbourhoodRingsHaveThreeKVerticesOnHexagons) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10.0, 6);
  // Always the middle triangle of a subdivision: the middle of a face of the icosahedron, far from its pentagons.
  const int middle = (1 << 12) - 1;
  const Neighbourhood n = neighbourhood_of(mesh, middle, 8);
  ASSERT_EQ(n.vertices.size(), 1u + 3 * 8 * 9 / 2);
  for (int k = 1; k <= 8; ++k) EXPECT_EQ(std::count(n.ring.begin(), n.ring.end(), k), 3 * k);
  EXPECT_TRUE(std::is_sorted(n.ring.begin(), n.ring.end()));
  EXPECT_EQ(std::set<int>(n.vertices.begin(), n.vertices.end()).size(), n.vertices.size());
  EXPECT_EQ(n.vertices[0], middle);
  EXPECT_EQ(n.vertices[1], mesh.neighbours[middle][0]);
  for (std::size_t i = 1; i < n.vertices.size(); ++i) {  // ring k touches ring k-1
    bool touches = false;
    for (int w : mesh.neighbours[n.vertices[i]]) {
      const auto at = std::find(n.vertices.begin(), n.vertices.end(), w);
      touches |= at != n.vertices.end() && n.ring[at - n.vertices.begin()] == n.ring[i] - 1;
    }
    EXPECT_TRUE(touches) << "entry " << i;
  }
}

TEST(SimplexMesh, NeighbourhoodLimits) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10.0, 2);
  EXPECT_EQ(neighbourhood_of(mesh, 5, 0).vertices, std::vector<int>{5});
  EXPECT_EQ(neighbourhood_of(mesh, 5, 1000).vertices.size(), 320u);
  EXPECT_THROW(neighbourhood_of(mesh, 320, 1), Error);
  EXPECT_THROW(neighbourhood_of(mesh, -1, 1), Error);
  EXPECT_THROW(neighbourhood_of(mesh, 0, -1), Error);
}

}  // namespace
}  // namespace simplexseg
