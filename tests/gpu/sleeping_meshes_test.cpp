// SPDX-License-Identifier: Apache-2.0
// Sleeping meshes are excluded from steps, which must not change the results for the others (the benchmark
// beside_sleeping measures the time).
#include <functional>
#include <string>

#include "mesh/mesh_geometry.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class SleepingMeshesTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(SleepingMeshesTest);

const ForceParameters& internal() {
  static const ForceParameters forces = with({{"smoothing", "weight", 0.4f}, {"shape_memory", "weight", 0.1f}});
  return forces;
}
const ForceParameters& one_of_each_force() {
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

std::vector<char> only(int sleeping, std::size_t meshes) {
  std::vector<char> asleep(meshes, 0);
  asleep[sleeping] = 1;
  return asleep;
}

/// Runs the scene in many batches while one mesh sleeps, and without that mesh. Then wakes it.
void expect_no_effect_of_sleep(const TestScene& scene, int sleeping,
                               const std::function<std::unique_ptr<Engine>()>& make_engine) {
  TestScene without = scene;
  without.meshes.erase(without.meshes.begin() + sleeping);
  without.points.clear();
  for (EnginePoint point : scene.points)
    if (point.mesh != sleeping)
      without.points.push_back({point.mesh - (point.mesh > sleeping ? 1 : 0), point.position_mm});
  const auto engine = make_engine(), other = make_engine();
  load(*engine, scene), load(*other, without);
  const StepOutcome first = engine->step(3);
  other->step(3);
  engine->set_asleep(only(sleeping, scene.meshes.size()));
  other->refresh();  // a change of the sleeping meshes is followed by a refresh
  const Positions pose = positions_of(*engine, scene, sleeping);
  EXPECT_GT(largest_distance(pose, scene.meshes[sleeping].mesh.positions), 0.001) << "moved before it fell asleep";
  StepOutcome outcome, outcome_without;
  for (int batch = 0; batch < 20; ++batch) outcome = engine->step(3), outcome_without = other->step(3);
  EXPECT_TRUE(same_bits(positions_of(*engine, scene, sleeping), pose));
  EXPECT_EQ(outcome.mean_move_mm[sleeping], first.mean_move_mm[sleeping]) << "measured before it fell asleep";
  EXPECT_EQ(outcome.mean_edge_mm[sleeping], first.mean_edge_mm[sleeping]);
  for (int k = 0; k < static_cast<int>(without.meshes.size()); ++k) {
    const int own = k < sleeping ? k : k + 1;
    EXPECT_TRUE(same_bits(positions_of(*engine, scene, own), positions_of(*other, without, k))) << "mesh " << own;
    EXPECT_GT(largest_distance(positions_of(*engine, scene, own), scene.meshes[own].mesh.positions), 0.01);
    EXPECT_EQ(outcome.mean_edge_mm[own], outcome_without.mean_edge_mm[k]);
    EXPECT_EQ(outcome.mean_move_mm[own], outcome_without.mean_move_mm[k]);
  }

  // A mesh that was woken moves as in an engine that is loaded with the current poses. Its velocity is 0.
  TestScene now = scene;
  for (std::size_t k = 0; k < now.meshes.size(); ++k) {
    TestMesh& mesh = now.meshes[k];
    mesh.previous.resize(mesh.mesh.positions.size());
    engine->read(static_cast<int>(k), mesh.mesh.positions, mesh.previous);
  }
  EXPECT_TRUE(same_bits(now.meshes[sleeping].previous, pose));
  std::vector<ForceParameters> forces;
  for (const TestMesh& mesh : now.meshes) forces.push_back(mesh.forces);
  engine->set_asleep(std::vector<char>(now.meshes.size(), 0));
  engine->set_parameters(forces, scene.simulation);  // restarts the estimates of the solvers, as a load does
  engine->step(10);
  const auto loaded = make_engine();
  std::vector<EngineMesh> meshes = engine_meshes(now);
  for (std::size_t k = 0; k < meshes.size(); ++k)  // the unit "edges" of parameters
    meshes[k].edge_mm = mean_edge_mm(scene.meshes[k].mesh.positions, scene.meshes[k].mesh.neighbours);
  loaded->set_volume(now.volume);
  loaded->load(meshes, now.simulation, now.points);
  loaded->step(10);
  EXPECT_FALSE(same_bits(positions_of(*engine, now, sleeping), pose));
  EXPECT_TRUE(same_bits(positions_of(*engine, now, sleeping), positions_of(*loaded, now, sleeping)));
}

TEST_P(SleepingMeshesTest, SleepDoesNotChangeOtherMeshes) {
  for (const int sleeping : {0, 1, 2}) {
    SCOPED_TRACE("sleeping " + std::to_string(sleeping));
    // Small meshes that end within a block, and a large one.
    expect_no_effect_of_sleep(scene_of({1, 0, 2}, internal()), sleeping, make_engine);
    expect_no_effect_of_sleep(scene_of({2, 4, 3}, internal()), sleeping, make_engine);
    TestScene scene = scene_of({1, 0, 2}, one_of_each_force());
    scene.points = {{0, {23.1, 2.2, 1.3}}, {1, {-4.2, -14.1, 9.7}}, {2, {1, 22, 3}}};
    expect_no_effect_of_sleep(scene, sleeping, make_engine);
    TestScene searching = scene_of({2, 4, 3}, one_of_each_force());
    searching.points = {{0, {23.1, 2.2, 1.3}}, {2, {1, 22, 3}}};
    expect_no_effect_of_sleep(searching, sleeping, make_engine);
    searching.simulation.solver_choice = static_cast<float>(Solver::Damped);
    expect_no_effect_of_sleep(searching, sleeping, make_engine);
    searching.simulation.solver_choice = static_cast<float>(Solver::Multigrid);
    expect_no_effect_of_sleep(searching, sleeping, make_engine);
  }
}

TEST_P(SleepingMeshesTest, EverySecondOfMany) {
  TestScene scene = scene_of({3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3}, internal());
  const Positions expected = run(scene_of({3}, internal()), 60);
  const auto engine = make_engine();
  load(*engine, scene);
  std::vector<char> asleep(scene.meshes.size(), 0);
  for (std::size_t k = 0; k < asleep.size(); k += 2) asleep[k] = 1;
  engine->set_asleep(asleep);
  for (int batch = 0; batch < 20; ++batch) engine->step(3);
  for (int k = 0; k < static_cast<int>(scene.meshes.size()); ++k)
    EXPECT_TRUE(same_bits(positions_of(*engine, scene, k), k % 2 == 0 ? scene.meshes[k].mesh.positions : expected))
        << "mesh " << k;
}

TEST_P(SleepingMeshesTest, MeshesLoadedAsleepAreMeasured) {
  TestScene scene = scene_of({2, 3}, one_of_each_force());
  const auto engine = make_engine();
  load(*engine, scene);
  std::vector<EngineMesh> meshes = engine_meshes(scene);
  meshes[1].asleep = true;
  engine->load(meshes, scene.simulation, scene.points);
  const StepOutcome before = engine->step(0);
  EXPECT_EQ(before.steps, 0);
  EXPECT_NEAR(before.mean_edge_mm[1], mean_edge_mm(scene.meshes[1].mesh.positions, scene.meshes[1].mesh.neighbours),
              1e-4);
  EXPECT_EQ(before.folded_vertices[1], 0);
  const StepOutcome after = engine->step(5);
  EXPECT_EQ(after.mean_edge_mm[1], before.mean_edge_mm[1]);
  EXPECT_TRUE(same_bits(positions_of(*engine, scene, 1), scene.meshes[1].mesh.positions));
  EXPECT_FALSE(same_bits(positions_of(*engine, scene, 0), scene.meshes[0].mesh.positions));
}

TEST_P(SleepingMeshesTest, StepsOfSleepingMeshesRunNoKernel) {
  TestScene scene = scene_of({1, 0, 2}, one_of_each_force());
  const auto engine = make_engine();
  load(*engine, scene);
  engine->set_asleep(std::vector<char>(3, 1));
  const auto launches = [&] {
    std::uint64_t sum = 0;
    for (const Engine::KernelCount& kernel : engine->kernel_counts()) sum += kernel.launches;
    return sum;
  };
  const std::uint64_t before = launches();
  for (int batch = 0; batch < 5; ++batch) EXPECT_EQ(engine->step(7).steps, 7);
  EXPECT_EQ(launches(), before);
  for (int k : {0, 1, 2}) EXPECT_TRUE(same_bits(positions_of(*engine, scene, k), scene.meshes[k].mesh.positions));
  engine->set_asleep(std::vector<char>(3, 0));
  EXPECT_EQ(engine->step(5).steps, 5);
  for (int k : {0, 1, 2}) EXPECT_FALSE(same_bits(positions_of(*engine, scene, k), scene.meshes[k].mesh.positions));
}

}  // namespace
}  // namespace simplexseg
