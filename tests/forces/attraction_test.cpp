// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "forces/force_list.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

class AttractionTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(AttractionTest);

/// Error in mm from sums in units of 2^-28 over a weight of 0.005 at the rim of the largest patch, and float positions.
constexpr double kFixedPointError = 2e-5;

/// Sphere of 10 mm with attraction only, k dt^2 = 1, damping 1.
TestScene pulled_sphere(float order, std::initializer_list<Vector3d> points, int level = 3) {
  TestScene scene;
  scene.meshes.resize(1);
  scene.meshes[0].mesh = make_sphere({0, 0, 0}, 10, level);
  scene.meshes[0].forces = with({{"attraction", "weight", 4}, {"attraction", "order", order}});
  for (const Vector3d& p : points) scene.points.push_back({0, p});
  scene.simulation = simulation(0.5f, 1);
  return scene;
}
int nearest_to(const Positions& positions, const Vector3d& point) {
  int best = 0;
  for (std::size_t k = 1; k < positions.size(); ++k)
    if ((positions[k].cast<double>() - point).squaredNorm() < (positions[best].cast<double>() - point).squaredNorm())
      best = static_cast<int>(k);
  return best;
}
std::vector<int> moved_vertices(const Positions& before, const Positions& after) {
  std::vector<int> moved;
  for (std::size_t k = 0; k < before.size(); ++k)
    if (before[k] != after[k]) moved.push_back(static_cast<int>(k));
  return moved;
}

TEST_P(AttractionTest, TheNearestVertexLandsOnThePointInOneStep) {
  for (float order : {0.0f, 1.0f, 5.0f, 10.0f}) {
    const Vector3d point(7, 9, -4);
    const TestScene scene = pulled_sphere(order, {point});
    const Positions& start = scene.meshes[0].mesh.positions;
    const int nearest = nearest_to(start, point);
    const Positions end = run(scene, 1);
    EXPECT_LT((end[nearest].cast<double>() - point).norm(), 1e-5) << "order " << order;
    // The neighbourhood follows by ring weights; no other vertex moves.
    const Neighbourhood patch = neighbourhood_of(scene.meshes[0].mesh, nearest, static_cast<int>(order));
    Positions expected = start;
    for (std::size_t k = 0; k < patch.vertices.size(); ++k) {
      const double w = AttractionForce::ring_weight(patch.ring[k], static_cast<int>(order));
      expected[patch.vertices[k]] += (w * (point - start[nearest].cast<double>())).cast<float>();
    }
    EXPECT_LT(largest_distance(end, expected), kFixedPointError) << "order " << order;
    EXPECT_EQ(moved_vertices(start, end).size(), patch.vertices.size()) << "order " << order;
  }
}

TEST_P(AttractionTest, RingWeightsFallFromOneToZero) {
  for (int order = 0; order <= kMaxNeighbourhoodOrder; ++order) {
    EXPECT_EQ(AttractionForce::ring_weight(0, order), 1.0f);
    for (int ring = 1; ring <= order; ++ring) {
      EXPECT_LT(AttractionForce::ring_weight(ring, order), AttractionForce::ring_weight(ring - 1, order));
      EXPECT_GT(AttractionForce::ring_weight(ring, order), 0.0f);
    }
    EXPECT_EQ(AttractionForce::ring_weight(order + 1, order), 0.0f);
  }
}

TEST_P(AttractionTest, TiesGoToTheLowestIndex) {
  // Four vertices at exactly equal distances from the origin, in mesh 0 and in mesh 1.
  TestScene scene = pulled_sphere(0, {});
  scene.meshes[0].mesh =
      dual_of({{{3, 3, 3}, {3, -3, -3}, {-3, 3, -3}, {-3, -3, 3}}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}});
  scene.meshes.push_back(scene.meshes[0]);
  for (int mesh : {0, 1}) {
    scene.points = {{mesh, {0, 0, 0}}};
    const Positions end = run(scene, 1);
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3f start = scene.meshes[0].mesh.positions[k % 4];
      if (k == 4 * mesh) {
        EXPECT_LT(end[k].norm(), 1e-5f);
      } else {
        EXPECT_EQ(end[k], start) << k;
      }
    }
  }
}

TEST_P(AttractionTest, SeveralPointsOnOneVertexAreAveraged) {
  // Vertex 0 is nearest to both points and moves to their midpoint.
  TestScene scene = pulled_sphere(0, {});
  const Vector3d p = scene.meshes[0].mesh.positions[0].cast<double>(), n = p.normalized(), side = n.unitOrthogonal();
  const Vector3d a = p + 2 * n + 0.2 * side, b = p + n - 0.1 * side;
  scene.points = {{0, a}, {0, b}};
  EXPECT_LT((run(scene, 1)[0].cast<double>() - 0.5 * (a + b)).norm(), 1e-5);
}

TEST_P(AttractionTest, OverlappingPatchesAreAveragedByWeight) {
  const Vector3d a(0, 2, 13), b(0, -2, 12);
  const int order = 6;
  const TestScene scene = pulled_sphere(static_cast<float>(order), {a, b});
  const SimplexMesh& mesh = scene.meshes[0].mesh;
  std::map<int, std::pair<double, Vector3d>> sums;
  for (const Vector3d& c : {a, b}) {
    const int nearest = nearest_to(mesh.positions, c);
    const Neighbourhood patch = neighbourhood_of(mesh, nearest, order);
    for (std::size_t k = 0; k < patch.vertices.size(); ++k) {
      const double w = AttractionForce::ring_weight(patch.ring[k], order);
      auto& [weight, pull] = sums.try_emplace(patch.vertices[k], 0.0, Vector3d::Zero()).first->second;
      weight += w;
      pull += w * w * (c - mesh.positions[nearest].cast<double>());
    }
  }
  Positions expected = mesh.positions;
  for (const auto& [vertex, sum] : sums) expected[vertex] += (sum.second / sum.first).cast<float>();
  ASSERT_NE(nearest_to(mesh.positions, a), nearest_to(mesh.positions, b));
  EXPECT_LT(largest_distance(run(scene, 1), expected), kFixedPointError);
}

TEST_P(AttractionTest, ThePointsOfOneMeshDoNotMoveAnother) {
  TestScene scene = pulled_sphere(10, {Vector3d(0, 0, 12)});
  scene.meshes.push_back(scene.meshes[0]);
  scene.points[0].mesh = 1;
  const Positions end = run(scene, 20);
  const Positions& start = scene.meshes[0].mesh.positions;
  EXPECT_TRUE(same_bits(Positions(end.begin(), end.begin() + start.size()), start));
  EXPECT_FALSE(same_bits(Positions(end.begin() + start.size(), end.end()), start));
}

TEST_P(AttractionTest, RemovedPointsDoNotPull) {
  const TestScene scene = pulled_sphere(3, {Vector3d(0, 0, 12)});
  const auto engine = make_engine();
  const Positions pulled = simplexseg::run(*engine, scene, 5);
  engine->set_points({});
  engine->step(5);
  EXPECT_TRUE(same_bits(positions_of(*engine, scene), pulled));
}

TEST_P(AttractionTest, TheNearestVertexIsUpdatedAtEachRefresh) {
  // The sphere moves past a point that pulls weakly: only vertices bound to it deviate from the common motion.
  auto touched = [&](int interval, bool refresh_in_between) {
    TestScene scene = pulled_sphere(0, {Vector3d(0, 0, 10.5)});
    scene.meshes[0].forces = with({{"attraction", "weight", 0.01f}, {"attraction", "order", 0}});
    scene.meshes[0].previous = scene.meshes[0].mesh.positions;
    for (Eigen::Vector3f& p : scene.meshes[0].previous) p[0] -= 0.5f;
    scene.simulation = simulation(1, 0, interval);
    const auto engine = make_engine();
    load(*engine, scene);
    engine->step(5);
    if (refresh_in_between) engine->refresh();
    engine->step(5);
    const Positions end = positions_of(*engine, scene);
    std::vector<int> vertices;
    for (int k = 0; k < scene.meshes[0].mesh.vertex_count(); ++k)
      if ((end[k] - scene.meshes[0].mesh.positions[k] - Eigen::Vector3f(5, 0, 0)).norm() > 1e-3f) vertices.push_back(k);
    return vertices;
  };
  TestScene scene = pulled_sphere(0, {});
  Positions halfway = scene.meshes[0].mesh.positions;
  const int first = nearest_to(halfway, {0, 0, 10.5});
  for (Eigen::Vector3f& p : halfway) p[0] += 2.5f;
  const int second = nearest_to(halfway, {0, 0, 10.5});
  ASSERT_NE(first, second);
  EXPECT_EQ(touched(50, false), std::vector<int>{first});
  EXPECT_EQ(touched(50, true), (std::vector<int>{std::min(first, second), std::max(first, second)}));
  EXPECT_EQ(touched(5, false), touched(50, true));
  EXPECT_GT(touched(1, false).size(), 2u);
}

TEST_P(AttractionTest, TheMeshEndsAtThePointAmongAllOtherForces) {
  // Within half a voxel (0.5 mm), for points outside and inside the edge.
  for (double radius : {23.0, 16.0}) {
    TestScene scene = busy_scene(3, 5);
    scene.meshes[0].forces = with({{"smoothing", "weight", 0.5f},
                                   {"gradient", "weight", 0.3f},
                                   {"evidence", "weight", 0.5f},
                                   {"attraction", "weight", 4}});
    const Vector3d point = radius * Vector3d(0.48, 0.6, 0.64);
    scene.points = {{0, point}};
    scene.simulation = limited(1, 0.9f, 3);
    const Positions end = run(scene, 300);
    const double distance = (end[nearest_to(end, point)].cast<double>() - point).norm();
    EXPECT_LT(distance, 0.5) << "radius " << radius;
  }
}

TEST_P(AttractionTest, ImageForcesFadeAtThePoint) {
  auto distance = [&](float fade) {
    TestScene scene = busy_scene(3);
    scene.meshes[0].forces = with({{"smoothing", "weight", 0.5f},
                                   {"gradient", "weight", 1},
                                   {"gradient", "pull", 0},
                                   {"gradient", "samples", 12},
                                   {"attraction", "weight", 1},
                                   {"attraction", "image_fade", fade}});
    const Vector3d point(0, 0, 22);
    scene.points = {{0, point}};
    scene.simulation = limited(1, 0.9f, 1);
    const Positions end = run(scene, 200);
    return (end[nearest_to(end, point)].cast<double>() - point).norm();
  };
  EXPECT_LT(2 * distance(1), distance(0));
}

TEST_P(AttractionTest, OnlyCompleteRingsFollow) {
  // A circle of vertices with chords, whose neighbourhoods double from ring to ring and exceed the size of a patch.
  constexpr int kCount = 1024;
  TestScene scene = pulled_sphere(10, {{11, 0, 0}});
  SimplexMesh& mesh = scene.meshes[0].mesh;
  mesh.positions.clear(), mesh.neighbours.assign(kCount, {-1, -1, -1});
  for (int k = 0; k < kCount; ++k) {
    const float turn = static_cast<float>(2 * M_PI * k / kCount);
    mesh.positions.push_back({10 * std::cos(turn), 10 * std::sin(turn), std::sin(40 * turn)});
    mesh.neighbours[k][0] = (k + 1) % kCount, mesh.neighbours[k][1] = (k + kCount - 1) % kCount;
  }
  for (int k = 0; k < kCount; ++k) {
    if (mesh.neighbours[k][2] >= 0) continue;
    int chord = (k + 2 + (k * 389) % (kCount - 2)) % kCount;
    while (mesh.neighbours[chord][2] >= 0 || chord == k) chord = (chord + 1) % kCount;
    mesh.neighbours[k][2] = chord, mesh.neighbours[chord][2] = k;
  }
  const Positions& start = mesh.positions;
  const std::vector<int> moved = moved_vertices(start, run(scene, 1));
  const Neighbourhood rings = neighbourhood_of(mesh, nearest_to(start, {11, 0, 0}), 10);
  ASSERT_GT(rings.vertices.size(), std::size_t(kMaxPatch));
  std::map<int, int> of_ring, moved_of_ring;
  for (std::size_t k = 0; k < rings.vertices.size(); ++k) {
    ++of_ring[rings.ring[k]];
    moved_of_ring[rings.ring[k]] += std::binary_search(moved.begin(), moved.end(), rings.vertices[k]);
  }
  std::size_t whole = 0;
  for (const auto& [ring, count] : of_ring) {
    EXPECT_TRUE(moved_of_ring[ring] == 0 || moved_of_ring[ring] == count)
        << moved_of_ring[ring] << " of " << count << " vertices of ring " << ring;
    whole += moved_of_ring[ring];
  }
  EXPECT_EQ(whole, moved.size());
  EXPECT_GT(whole, std::size_t(kMaxPatch) / 3) << "as many rings as fit into a patch";
}

}  // namespace
}  // namespace simplexseg
