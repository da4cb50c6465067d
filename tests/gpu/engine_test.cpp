// SPDX-License-Identifier: Apache-2.0
// Guarantees of the engine for all forces: reproducibility, independence of meshes, failures that are undone.
#include <algorithm>
#include <cmath>
#include <limits>

#include "forces/force_list.h"
#include "forces/region_model.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class EngineCoreTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(EngineCoreTest);

TestScene with_all_forces(int level, double noise_sigma = 10) {
  TestScene scene = busy_scene(level, noise_sigma);
  scene.meshes[0].forces = with({{"smoothing", "weight", 0.4f},
                                 {"shape_memory", "weight", 0.1f},
                                 {"gradient", "weight", 0.2f},
                                 {"intensity_profile", "weight", 0.2f},
                                 {"evidence", "weight", 0.2f},
                                 {"attraction", "weight", 0.5f}});
  scene.simulation = limited(1, 0.9f, 3);
  return scene;
}

TEST_P(EngineCoreTest, ARerunGivesTheSameBits) {
  const TestScene scene = with_all_forces(3);
  const Positions first = run(scene, 100);
  EXPECT_GT(largest_distance(first, scene.meshes[0].mesh.positions), 0.5);
  EXPECT_TRUE(same_bits(run(scene, 100), first));
  // Repeats the run on an engine that has run another scene, in batches of any size.
  const auto engine = make_engine();
  simplexseg::run(*engine, busy_scene(2), 7);
  load(*engine, scene);
  for (int batch : {1, 2, 30, 7, 60}) engine->step(batch);
  EXPECT_TRUE(same_bits(positions_of(*engine, scene), first));
}

TEST(CpuEngine, TheNumberOfThreadsDoesNotMatter) {
  // Two meshes of 5120 vertices: enough blocks for three threads.
  TestScene scene = with_all_forces(4);
  scene.meshes.push_back(scene.meshes[0]);
  for (Eigen::Vector3f& p : scene.meshes[1].mesh.positions) p[1] += 1.5f;
  scene.points.push_back({1, {1.0, 22.5, -3.0}});
  const Positions one = run(*make_cpu_engine(1), scene, 300);
  for (int threads : {2, 3})
    EXPECT_TRUE(same_bits(run(*make_cpu_engine(threads), scene, 300), one)) << threads << " threads";
}

TEST_P(EngineCoreTest, EachOfSeveralMeshesMovesAsIfAlone) {
  TestScene one = with_all_forces(3), two = with_all_forces(2), three = with_all_forces(4);
  weight_of(two.meshes[0].forces, ForceId::Evidence) = 0.7f;
  weight_of(two.meshes[0].forces, ForceId::Attraction) = 0;
  weight_of(three.meshes[0].forces, ForceId::Smoothing) = 0;
  set(three.meshes[0].forces, {"evidence", "averaging", 4});
  three.meshes[0].finest = false;
  TestScene all = one;
  all.meshes.push_back(two.meshes[0]), all.meshes.push_back(three.meshes[0]);
  for (EnginePoint p : one.points) all.points.push_back({2, p.position_mm});
  // Without image forces on one of them, and a profile of another length on another.
  set(all.meshes[1].forces, {"intensity_profile", "half_length", 2});
  all.meshes[1].profiles =
      profile_reference_of(make_sphere({0, 0, 0}, kPhantomRadius, 2), all.volume, all.meshes[1].forces);
  two.meshes[0] = all.meshes[1];
  Positions expected = run(one, 40);
  for (const TestScene& scene : {two, three}) {
    const Positions next = run(scene, 40);
    expected.insert(expected.end(), next.begin(), next.end());
  }
  EXPECT_TRUE(same_bits(run(all, 40), expected));
}

TEST_P(EngineCoreTest, EveryVoxelTypeGivesTheSame) {
  PhantomSettings settings;
  settings.background = 20, settings.contrast = 80, settings.noise_sigma = 4;
  Positions expected;
  for (VoxelType type : {VoxelType::Int16, VoxelType::Int8, VoxelType::UInt8, VoxelType::UInt16, VoxelType::Int32,
                         VoxelType::UInt32, VoxelType::Float32, VoxelType::Float64}) {
    TestScene scene = with_all_forces(2);
    // The integers of the first type, stored in every other type.
    settings.type = VoxelType::Int16;
    const Volume integers = make_phantom("sphere", settings).image;
    scene.volume = Volume(integers.geometry(), type);
    visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
      for (std::size_t k = 0; k < integers.geometry().voxel_count(); ++k)
        scene.volume.voxels<T>()[k] = static_cast<T>(integers.voxels<std::int16_t>()[k]);
    });
    TestMesh& m = scene.meshes[0];
    m.region = estimate_region(scene.volume, m.mesh, 20);
    m.profiles = profile_reference_of(make_sphere({0, 0, 0}, kPhantomRadius, 2), scene.volume, m.forces);
    const Positions end = run(scene, 60);
    if (expected.empty()) expected = end;
    if (GetParam() == "cpu")
      EXPECT_TRUE(same_bits(end, expected)) << to_string(type);
    else  // a texture unit interpolates some types, with weights of 8 bits, and cannot read others
      EXPECT_LE(largest_distance(end, expected), 0.1) << to_string(type);
  }
}

TEST_P(EngineCoreTest, ChangedParametersActAsIfLoaded) {
  TestScene before = with_all_forces(3);
  weight_of(before.meshes[0].forces, ForceId::Evidence) = 0;
  weight_of(before.meshes[0].forces, ForceId::IntensityProfile) = 0;
  // The region's reach is given in edge lengths at loading, but is at least 2.5 voxels, as here.
  set(before.meshes[0].forces, {"evidence", "reach", 0.5f});
  const auto changed = make_engine();
  simplexseg::run(*changed, before, 20);

  TestScene after = with_all_forces(3);
  weight_of(after.meshes[0].forces, ForceId::ShapeMemory) = 0;
  set(after.meshes[0].forces, {"evidence", "reach", 0.5f});
  after.simulation.damping = 0.5f, after.simulation.refresh_interval = 2;
  after.meshes[0].mesh.positions.resize(before.meshes[0].mesh.positions.size());
  after.meshes[0].previous = after.meshes[0].mesh.positions;
  changed->read(0, after.meshes[0].mesh.positions, after.meshes[0].previous);
  const std::vector<ForceParameters> parameters{after.meshes[0].forces};
  changed->set_parameters(parameters, after.simulation);
  changed->refresh();
  changed->step(20);
  const auto loaded = make_engine();
  EXPECT_TRUE(same_bits(simplexseg::run(*loaded, after, 20), positions_of(*changed, after)));
  auto text_of = [](const Engine& engine) {
    std::string text;
    for (const Engine::AllocatedArray& a : engine.allocated_arrays())
      text += a.name + " " + std::to_string(a.bytes) + "\n";
    return text;
  };
  EXPECT_EQ(text_of(*changed), text_of(*loaded));
}

TEST_P(EngineCoreTest, OnlyTheLastSettingsBeforeAStepCount) {
  const TestScene first = with_all_forces(2);
  TestScene last = first;
  weight_of(last.meshes[0].forces, ForceId::Attraction) = 1.5f;
  last.points[0].position_mm += Eigen::Vector3d(4, 0, 2);
  const auto often = make_engine(), once = make_engine();
  for (Engine* engine : {often.get(), once.get()}) load(*engine, first);
  // The uploads exceed the staging memory in total.
  TestScene other = first;
  other.points.resize(200, first.points[0]);
  for (int k = 0; k < 100; ++k) {
    weight_of(other.meshes[0].forces, ForceId::Attraction) = 0.01f * static_cast<float>(k);
    for (EnginePoint& p : other.points) p.position_mm[1] += 0.1;
    often->set_points(other.points);
    often->set_parameters(std::vector{other.meshes[0].forces}, other.simulation);
  }
  for (Engine* engine : {often.get(), once.get()}) {
    engine->set_points(last.points);
    engine->set_parameters(std::vector{last.meshes[0].forces}, last.simulation);
    engine->step(40);
  }
  EXPECT_TRUE(same_bits(positions_of(*often, last), positions_of(*once, last)));
  EXPECT_GT(largest_distance(positions_of(*once, last), run(first, 40)), 0.1);
}

TEST_P(EngineCoreTest, ProfilesOfAMeshThatUsesThemLater) {
  // The stride stays the same while the mesh that needs it changes.
  TestScene scene = with_all_forces(2);
  scene.meshes.push_back(scene.meshes[0]);
  weight_of(scene.meshes[1].forces, ForceId::IntensityProfile) = 0;
  const auto engine = make_engine();
  load(*engine, scene);
  std::swap(scene.meshes[0].forces, scene.meshes[1].forces);
  const std::vector<ForceParameters> swapped{scene.meshes[0].forces, scene.meshes[1].forces};
  engine->set_parameters(swapped, scene.simulation);
  engine->step(10);
  const Positions expected = run(scene, 10);
  EXPECT_TRUE(
      same_bits(positions_of(*engine, scene, 1), Positions(expected.begin() + expected.size() / 2, expected.end())));
}

TEST_P(EngineCoreTest, NoSearchOnAMeshWithoutTheForce) {
  // The searches of the mesh without the force would be longer than those of the other mesh.
  TestScene scene = with_all_forces(2), alone = scene;
  set(scene.meshes[0].forces, {"evidence", "source", 1}), set(scene.meshes[0].forces, {"evidence", "local", 0.5f});
  alone.meshes[0].forces = scene.meshes[0].forces;
  const TestScene idle = busy_scene(6);
  scene.meshes.push_back(idle.meshes[0]);
  for (const char* force : {"gradient", "intensity_profile", "evidence"})
    set(scene.meshes[1].forces, {force, "samples", 24});
  set(scene.meshes[1].forces, {"evidence", "source", 1});
  const auto engine = make_engine();
  load(*engine, scene);
  EXPECT_FALSE(engine->step(4).failure.has_value());
  EXPECT_TRUE(same_bits(positions_of(*engine, scene, 1), idle.meshes[0].mesh.positions));
  EXPECT_TRUE(same_bits(positions_of(*engine, scene, 0), run(alone, 4)));
  std::vector<Vec4> targets(idle.meshes[0].mesh.positions.size());
  for (const ForceInfo& force : force_list()) {
    if (force.targets == nullptr) continue;
    engine->read_targets(1, force.id, targets);
    EXPECT_TRUE(std::all_of(targets.begin(), targets.end(), [](const Vec4& t) {
      return t.x == 0 && t.y == 0 && t.z == 0 && t.w == 0;
    })) << force.name;
  }
}

TEST_P(EngineCoreTest, TheLongestSearchesOfALargeMesh) {
  // A device uses one thread per vertex and needs more than the default 48 KB of shared memory per block.
  TestScene scene = busy_scene(7);
  set(scene.meshes[0].forces, {"intensity_profile", "half_length", 8});
  scene.meshes[0].profiles = profile_reference_of(scene.meshes[0].mesh, scene.volume, scene.meshes[0].forces);
  for (const char* force : {"gradient", "intensity_profile", "evidence"}) {
    TestScene one = scene;
    ForceParameters& forces = one.meshes[0].forces;
    set(forces, {force, "weight", 0.5f}), set(forces, {force, "samples", 24}), set(forces, {"evidence", "source", 1});
    EXPECT_TRUE(all_finite(run(one, 1))) << force;
    if (std::string(force) == "gradient") continue;  // it needs no scratch memory
    one.points = {{0, {23.1, 2.2, 1.3}}};            // the binding runs concurrently with the search
    weight_of(forces, ForceId::Attraction) = 0.5f;
    EXPECT_TRUE(all_finite(run(one, 1))) << force;
  }
}

TEST_P(EngineCoreTest, AForceWithoutItsReferenceDoesNotAct) {
  TestScene scene = busy_scene();
  scene.meshes[0].forces = with({{"shape_memory", "weight", 1},
                                 {"intensity_profile", "weight", 1},
                                 {"evidence", "weight", 1},
                                 {"evidence", "local", 0},
                                 {"evidence", "edge", 0}});
  scene.meshes[0].shape.clear(), scene.meshes[0].profiles.resize(5), scene.meshes[0].region = {};
  scene.meshes[0].field.clear();
  EXPECT_TRUE(same_bits(run(scene, 5), scene.meshes[0].mesh.positions));
  set(scene.meshes[0].forces, {"evidence", "source", 0});
  EXPECT_TRUE(same_bits(run(scene, 5), scene.meshes[0].mesh.positions));
  scene = with_all_forces(2);
  scene.volume = {}, scene.meshes[0].field.clear();
  weight_of(scene.meshes[0].forces, ForceId::Attraction) = 0;
  scene.simulation = simulation(0.5f, 0.9f, 3);  // the timestep limit depends on all forces
  const Positions without_volume = run(scene, 5);
  scene.meshes[0].forces = with({{"smoothing", "weight", 0.4f}, {"shape_memory", "weight", 0.1f}});
  EXPECT_TRUE(same_bits(run(scene, 5), without_volume)) << "internal forces alone";
  EXPECT_GT(largest_distance(without_volume, scene.meshes[0].mesh.positions), 1e-3);
}

TEST_P(EngineCoreTest, NonFiniteVoxelsNeverReachThePositions) {
  TestScene scene = with_all_forces(3);
  const Volume clean = scene.volume;
  scene.volume = Volume(clean.geometry(), VoxelType::Float32);
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                       -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::max()};
  const std::span<float> voxels = scene.volume.voxels<float>();
  for (std::size_t k = 0; k < voxels.size(); ++k) voxels[k] = k % 97 == 0 ? bad[k / 97 % 4] : clean.voxels<float>()[k];
  TestMesh& m = scene.meshes[0];
  m.region = estimate_region(scene.volume, m.mesh, 20);
  m.profiles = profile_reference_of(make_sphere({0, 0, 0}, kPhantomRadius, 3), scene.volume, m.forces);
  const auto engine = make_engine();
  load(*engine, scene);
  const StepOutcome outcome = engine->step(100);
  const Positions end = positions_of(*engine, scene);
  EXPECT_TRUE(all_finite(end));
  EXPECT_FALSE(outcome.failure.has_value()) << "force " << static_cast<int>(outcome.failure->force);
  EXPECT_LT(largest_radial_error(end, kPhantomRadius), 15);
}

TEST_P(EngineCoreTest, AStepToNonFinitePositionsIsUndoneAndNamed) {
  for (ForceId force :
       {ForceId::Smoothing, ForceId::ShapeMemory, ForceId::Gradient, ForceId::Evidence, ForceId::Attraction}) {
    TestScene scene = with_all_forces(2);
    scene.meshes.insert(scene.meshes.begin(), scene.meshes[0]);
    scene.points[0].mesh = scene.points[1].mesh = 1;
    scene.simulation = simulation(0.5f, 0.9f);
    const auto engine = make_engine();
    load(*engine, scene);
    ASSERT_FALSE(engine->step(3).failure.has_value());
    weight_of(scene.meshes[1].forces, force) = 1e14f;
    const std::vector<ForceParameters> huge{scene.meshes[0].forces, scene.meshes[1].forces};
    const Positions before = positions_of(*engine, scene, 1), other = positions_of(*engine, scene, 0);
    engine->set_parameters(huge, scene.simulation);
    const StepOutcome outcome = engine->step(50);
    ASSERT_TRUE(outcome.failure.has_value()) << static_cast<int>(force);
    EXPECT_EQ(outcome.steps, static_cast<int>(outcome.cuts.size()) + 1) << "each undone step counts as a step";
    EXPECT_EQ(outcome.failure->mesh, 1);
    EXPECT_EQ(outcome.failure->force, force) << force_list()[static_cast<int>(outcome.failure->force)].name;
    EXPECT_GE(outcome.failure->vertex, 0);
    EXPECT_LT(outcome.failure->vertex, 320);
    EXPECT_TRUE(same_bits(positions_of(*engine, scene, 1), before));
    EXPECT_TRUE(same_bits(positions_of(*engine, scene, 0), other));
    // The run continues with a normal weight.
    weight_of(scene.meshes[1].forces, force) = 0.1f;
    const std::vector<ForceParameters> sane{scene.meshes[0].forces, scene.meshes[1].forces};
    engine->set_parameters(sane, scene.simulation);
    EXPECT_FALSE(engine->step(5).failure.has_value());
    EXPECT_TRUE(all_finite(positions_of(*engine, scene, 1)));
  }
}

TEST_P(EngineCoreTest, GrowingStepsAreUndoneForAnyBatchSize) {
  TestScene scene;
  scene.meshes.resize(2);
  for (TestMesh& m : scene.meshes) {
    m.mesh = with_noise(make_sphere({0, 0, 0}, 20, 2), 0.5);
    m.forces = with({{"smoothing", "weight", 1e-4f}, {"smoothing", "evenness", 0}, {"smoothing", "curvature", 0}});
  }
  weight_of(scene.meshes[1].forces, ForceId::Smoothing) = 1;
  scene.simulation = simulation(4, 0);
  const auto batch = make_engine(), single = make_engine();
  load(*batch, scene), load(*single, scene);
  const StepOutcome outcome = batch->step(200);
  EXPECT_FALSE(outcome.failure.has_value());
  EXPECT_EQ(outcome.steps, 200);
  ASSERT_FALSE(outcome.cuts.empty());
  for (const TimestepCut& cut : outcome.cuts) {
    EXPECT_EQ(cut.failure.mesh, 1);
    EXPECT_EQ(cut.failure.force, ForceId::Smoothing);
    EXPECT_LT(cut.factor, 1);
  }
  std::size_t cuts = 0;
  for (int k = 0; k < 200; ++k) cuts += single->step(1).cuts.size();
  EXPECT_EQ(cuts, outcome.cuts.size());
  for (int mesh : {0, 1}) {
    Positions a(scene.meshes[mesh].mesh.positions.size()), a_before = a, b = a, b_before = a;
    batch->read(mesh, a, a_before), single->read(mesh, b, b_before);
    EXPECT_TRUE(same_bits(a, b));
    EXPECT_TRUE(same_bits(a_before, b_before));
    for (const Eigen::Vector3f& p : a) EXPECT_LT(p.norm(), 25) << "smoothing alone only shrinks";
  }
}

TEST_P(EngineCoreTest, AnEmptyEngineSteps) {
  const auto engine = make_engine();
  EXPECT_EQ(engine->step(3).steps, 3);
  TestScene scene;
  load(*engine, scene);
  EXPECT_EQ(engine->step(3).steps, 3);
  EXPECT_TRUE(engine->step(3).mean_move_mm.empty());
  scene.volume = phantom("flat").image;
  load(*engine, scene);
  EXPECT_EQ(engine->step(3).steps, 3);
  EXPECT_EQ(engine->bytes_allocated(), scene.volume.bytes());
  // An empty load removes all meshes.
  simplexseg::run(*engine, with_all_forces(2), 3);
  load(*engine, scene);
  EXPECT_EQ(engine->bytes_allocated(), scene.volume.bytes());
}

TEST_P(EngineCoreTest, MeanMoveIsTheMeanOfTheLastStep) {
  TestScene scene = with_all_forces(3);
  const auto engine = make_engine();
  load(*engine, scene);
  const StepOutcome outcome = engine->step(9);
  Positions now(scene.meshes[0].mesh.positions.size()), before(now.size());
  engine->read(0, now, before);
  double sum = 0;
  for (std::size_t k = 0; k < now.size(); ++k) sum += (now[k] - before[k]).cast<double>().norm();
  EXPECT_NEAR(outcome.mean_move_mm.at(0), sum / static_cast<double>(now.size()), 1e-5);
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace simplexseg
