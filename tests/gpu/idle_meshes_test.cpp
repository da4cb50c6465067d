// SPDX-License-Identifier: Apache-2.0
// Settled meshes without forces are excluded from steps. This must change only the time of a step, not its results (the
// benchmark beside_idle measures the time).
#include <functional>
#include <string>

#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class IdleMeshesTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(IdleMeshesTest);

const ForceParameters& internal() {
  static const ForceParameters forces = with({{"smoothing", "weight", 0.4f}, {"shape_memory", "weight", 0.1f}});
  return forces;
}
const ForceParameters& all_forces() {
  static const ForceParameters forces = with({{"smoothing", "weight", 0.4f},
                                              {"shape_memory", "weight", 0.1f},
                                              {"gradient", "weight", 0.2f},
                                              {"intensity_profile", "weight", 0.2f},
                                              {"evidence", "weight", 0.2f},
                                              {"attraction", "weight", 0.5f}});
  return forces;
}

/// Scene with meshes of these levels and the same forces for all.
TestScene scene_of(std::initializer_list<int> levels, const ForceParameters& forces) {
  TestScene scene = busy_scene(0);
  scene.meshes.clear();
  for (int level : levels) {
    scene.meshes.push_back(busy_scene(level).meshes[0]);
    scene.meshes.back().forces = forces;
  }
  scene.points.clear();
  scene.simulation = limited(1, 0.9f, 3);
  return scene;
}

/// Runs the scene with one idle mesh and without that mesh, in many batches, from most of which the idle mesh is
/// excluded. Then restores the forces of the mesh.
void expect_no_effect_of_exclusion(const TestScene& scene, int idle,
                                   const std::function<std::unique_ptr<Engine>()>& make_engine) {
  TestScene with_idle = scene, without = scene;
  with_idle.meshes[idle].forces = weightless();
  without.meshes.erase(without.meshes.begin() + idle);
  without.points.clear();
  for (EnginePoint point : scene.points)
    if (point.mesh != idle) without.points.push_back({point.mesh - (point.mesh > idle ? 1 : 0), point.position_mm});
  const auto engine = make_engine(), other = make_engine();
  load(*engine, with_idle), load(*other, without);
  StepOutcome outcome, outcome_without;
  for (int batch = 0; batch < 20; ++batch) outcome = engine->step(3), outcome_without = other->step(3);
  EXPECT_TRUE(same_bits(positions_of(*engine, with_idle, idle), scene.meshes[idle].mesh.positions));
  for (int k = 0; k < static_cast<int>(without.meshes.size()); ++k) {
    const int own = k < idle ? k : k + 1;
    EXPECT_TRUE(same_bits(positions_of(*engine, with_idle, own), positions_of(*other, without, k))) << "mesh " << own;
    EXPECT_GT(largest_distance(positions_of(*engine, with_idle, own), scene.meshes[own].mesh.positions), 0.01);
    EXPECT_EQ(outcome.mean_edge_mm[own], outcome_without.mean_edge_mm[k]);
    EXPECT_EQ(outcome.mean_move_mm[own], outcome_without.mean_move_mm[k]);
  }
  EXPECT_EQ(outcome.mean_move_mm[idle], 0);
  EXPECT_GT(outcome.mean_edge_mm[idle], 0) << "measured before it was excluded";
  EXPECT_FALSE(outcome.inverted[idle]);

  // With its forces, the mesh moves as in an engine that is loaded with the current poses.
  TestScene now = scene;
  std::vector<ForceParameters> forces;
  for (std::size_t k = 0; k < now.meshes.size(); ++k) {
    TestMesh& mesh = now.meshes[k];
    mesh.previous.resize(mesh.mesh.positions.size());
    engine->read(static_cast<int>(k), mesh.mesh.positions, mesh.previous);
    forces.push_back(mesh.forces);
  }
  engine->set_parameters(forces, scene.simulation);
  engine->refresh();
  engine->step(10);
  const auto loaded = make_engine();
  load(*loaded, now);
  loaded->step(10);
  EXPECT_FALSE(same_bits(positions_of(*engine, now, idle), scene.meshes[idle].mesh.positions));
  EXPECT_TRUE(same_bits(positions_of(*engine, now, idle), positions_of(*loaded, now, idle)));
}

TEST_P(IdleMeshesTest, ExclusionDoesNotChangeAnyMesh) {
  for (const int idle : {0, 1, 2}) {
    SCOPED_TRACE("idle " + std::to_string(idle));
    // Small meshes that end within a block, and a large one.
    expect_no_effect_of_exclusion(scene_of({1, 0, 2}, internal()), idle, make_engine);
    expect_no_effect_of_exclusion(scene_of({2, 4, 3}, internal()), idle, make_engine);
    TestScene scene = scene_of({1, 0, 2}, all_forces());
    scene.points = {{0, {23.1, 2.2, 1.3}}, {1, {-4.2, -14.1, 9.7}}, {2, {1, 22, 3}}};
    expect_no_effect_of_exclusion(scene, idle, make_engine);
    TestScene searching = scene_of({2, 4, 3}, all_forces());
    searching.points = {{0, {23.1, 2.2, 1.3}}, {2, {1, 22, 3}}};
    expect_no_effect_of_exclusion(searching, idle, make_engine);
    searching.simulation.solver_choice = static_cast<float>(Solver::Damped);
    expect_no_effect_of_exclusion(searching, idle, make_engine);
  }
}

TEST_P(IdleMeshesTest, EverySecondOfMany) {
  TestScene scene = scene_of({3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3}, internal());
  const Positions expected = run(scene_of({3}, internal()), 60);
  for (std::size_t k = 0; k < scene.meshes.size(); k += 2) scene.meshes[k].forces = weightless();
  const auto engine = make_engine();
  load(*engine, scene);
  for (int batch = 0; batch < 20; ++batch) engine->step(3);
  for (int k = 0; k < static_cast<int>(scene.meshes.size()); ++k)
    EXPECT_TRUE(same_bits(positions_of(*engine, scene, k), k % 2 == 0 ? scene.meshes[k].mesh.positions : expected))
        << "mesh " << k;
}

TEST_P(IdleMeshesTest, AMovingMeshIsNotExcluded) {
  TestScene scene = scene_of({1, 0, 2}, all_forces());
  scene.meshes[0].forces = weightless();
  scene.meshes[0].previous = scene.meshes[0].mesh.positions;
  for (Eigen::Vector3f& p : scene.meshes[0].previous) p.x() -= 0.25f;
  scene.simulation = simulation(1, 0.5f);
  const auto engine = make_engine();
  load(*engine, scene);
  for (int batch = 0; batch < 4; ++batch) engine->step(1);
  const Positions x = positions_of(*engine, scene, 0);
  // 0.25 (1/2 + 1/4 + 1/8 + 1/16) mm
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(x[i].x() - scene.meshes[0].mesh.positions[i].x(), 0.25 * 15 / 16, 1e-4);
  for (int batch = 0; batch < 60; ++batch) engine->step(1);
  const Positions settled = positions_of(*engine, scene, 0);
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(settled[i].x() - scene.meshes[0].mesh.positions[i].x(), 0.25, 1e-4);
}

TEST_P(IdleMeshesTest, OnlyIdleMeshes) {
  TestScene scene = scene_of({1, 0, 2}, weightless());
  const auto engine = make_engine();
  load(*engine, scene);
  for (int batch = 0; batch < 5; ++batch) EXPECT_EQ(engine->step(7).steps, 7);
  for (int k : {0, 1, 2}) EXPECT_TRUE(same_bits(positions_of(*engine, scene, k), scene.meshes[k].mesh.positions));
  std::vector<ForceParameters> forces(3, with({{"smoothing", "weight", 1}}));
  engine->set_parameters(forces, scene.simulation);
  EXPECT_EQ(engine->step(5).steps, 5);
  for (int k : {0, 1, 2}) EXPECT_FALSE(same_bits(positions_of(*engine, scene, k), scene.meshes[k].mesh.positions));
}

}  // namespace
}  // namespace simplexseg
