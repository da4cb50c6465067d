// SPDX-License-Identifier: Apache-2.0
// Compares the code for eight vertices at once with the code for single vertices: the bits must be equal. Without AVX2
// both engines run the same code.
#include <algorithm>
#include <cmath>
#include <limits>

#include "forces/force_list.h"
#include "forces/region_model.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

bool same_numbers(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

/// Runs the steps with both kinds of code, in two batches, and compares all results of the engines.
void expect_equal_bits(const TestScene& scene, int steps, const std::string& what) {
  SCOPED_TRACE(what);
  const auto eights = make_cpu_engine(1, CpuCode::Fastest), plain = make_cpu_engine(1, CpuCode::Plain);
  load(*eights, scene), load(*plain, scene);
  for (const int batch : {1, steps - 1}) {
    const StepOutcome a = eights->step(batch), b = plain->step(batch);
    EXPECT_EQ(a.steps, b.steps);
    EXPECT_TRUE(same_numbers(a.mean_move_mm, b.mean_move_mm));
    EXPECT_TRUE(same_numbers(a.mean_edge_mm, b.mean_edge_mm));
    EXPECT_TRUE(same_numbers(a.residual_mm, b.residual_mm));
    EXPECT_EQ(a.folded_vertices, b.folded_vertices);
    EXPECT_EQ(a.inverted, b.inverted);
    ASSERT_EQ(a.failure.has_value(), b.failure.has_value());
    if (a.failure) {
      EXPECT_EQ(a.failure->mesh, b.failure->mesh);
      EXPECT_EQ(a.failure->vertex, b.failure->vertex);
      EXPECT_EQ(a.failure->force, b.failure->force);
    }
  }
  for (int k = 0; k < static_cast<int>(scene.meshes.size()); ++k) {
    SCOPED_TRACE("mesh " + std::to_string(k));
    EXPECT_TRUE(same_bits(positions_of(*eights, scene, k), positions_of(*plain, scene, k)));
    std::vector<Vec4> a(scene.meshes[k].mesh.positions.size()), b(a.size());
    for (const ForceInfo& force : force_list()) {
      if (force.targets == nullptr) continue;
      eights->read_targets(k, force.id, a), plain->read_targets(k, force.id, b);
      EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), [](const Vec4& x, const Vec4& y) {
        return x.x == y.x && x.y == y.y && x.z == y.z && x.w == y.w;
      })) << force.name;
    }
  }
}

/// Scene with meshes of 80, 20 and 320 vertices, whose groups of eight begin and end at any position.
TestScene three_meshes(const ForceParameters& forces) {
  TestScene scene = busy_scene(1);
  scene.meshes.push_back(busy_scene(0).meshes[0]);
  scene.meshes.push_back(busy_scene(2).meshes[0]);
  for (TestMesh& mesh : scene.meshes) mesh.forces = forces;
  scene.points = {{0, {23.1, 2.2, 1.3}}, {1, {-4.2, -14.1, 9.7}}, {2, {1, 22, 3}}};
  scene.simulation = limited(1, 0.9f, 3);
  return scene;
}

constexpr std::initializer_list<Setting> kAll = {{"smoothing", "weight", 0.4f}, {"shape_memory", "weight", 0.1f},
                                                 {"gradient", "weight", 0.2f},  {"intensity_profile", "weight", 0.2f},
                                                 {"evidence", "weight", 0.2f},  {"attraction", "weight", 0.5f}};

TEST(EightVertices, EveryForceAloneAndAllTogether) {
  for (const ForceInfo& force : force_list()) {
    ForceParameters forces = weightless();
    weight_of(forces, force.id) = 0.3f;
    expect_equal_bits(three_meshes(forces), 20, force.name);
  }
  expect_equal_bits(three_meshes(with(kAll)), 40, "all");
  TestScene noisy = busy_scene(3, 10);
  noisy.meshes[0].forces = with(kAll);
  expect_equal_bits(noisy, 60, "all, with noise");
}

TEST(EightVertices, EveryBranchOfAForce) {
  const auto check = [](std::initializer_list<Setting> settings, const std::string& what) {
    TestScene scene = three_meshes(with(settings));
    expect_equal_bits(scene, 12, what);
    scene.meshes[0].finest = false;
    expect_equal_bits(scene, 12, what + ", one mesh not on its finest level");
  };
  for (float evenness : {0.0f, 0.7f, 2.0f, 4.0f})
    for (float curvature : {0.0f, 0.6f})
      check({{"smoothing", "weight", 1}, {"smoothing", "evenness", evenness}, {"smoothing", "curvature", curvature}},
            "smoothing " + std::to_string(evenness) + " " + std::to_string(curvature));
  for (float scaling : {0.0f, 0.3f, 0.5f})
    check({{"shape_memory", "weight", 1}, {"shape_memory", "scaling", scaling}}, "shape " + std::to_string(scaling));
  for (float object : {0.0f, 1.0f, 2.0f})
    for (float samples : {1.0f, 6.0f, 24.0f})
      for (float pull : {0.0f, 1.0f})
        check({{"gradient", "weight", 0.5f},
               {"gradient", "object", object},
               {"gradient", "samples", samples},
               {"gradient", "pull", pull}},
              "gradient " + std::to_string(object) + " " + std::to_string(samples));
  for (float source : {0.0f, 1.0f})
    for (float local : {0.0f, 0.5f})
      for (float samples : {2.0f, 8.0f, 24.0f})
        check({{"evidence", "weight", 0.5f},
               {"evidence", "source", source},
               {"evidence", "local", local},
               {"evidence", "samples", samples},
               {"evidence", "averaging", samples == 8 ? 3.0f : 0.0f},
               {"evidence", "balloon", samples == 2 ? 0.3f : 0.0f}},
              "evidence " + std::to_string(source) + " " + std::to_string(local) + " " + std::to_string(samples));
}

TEST(EightVertices, AreasAndMasses) {
  TestScene scene = three_meshes(with(kAll));
  for (TestMesh& mesh : scene.meshes)
    for (Eigen::Vector3f& p : mesh.mesh.positions) p[2] *= 2;
  scene.simulation.area_in_mass = 0.7f, scene.simulation.area_in_force = 0.4f;
  expect_equal_bits(scene, 40, "areas in masses and forces");
}

TEST(EightVertices, EverySolver) {
  for (const Solver solver : {Solver::Verlet, Solver::Automatic, Solver::Damped, Solver::Multigrid}) {
    TestScene scene = three_meshes(with(kAll));
    scene.simulation.solver_choice = static_cast<float>(solver);
    expect_equal_bits(scene, 60, "solver " + std::to_string(static_cast<int>(solver)));
  }
}

TEST(EightVertices, DifferentMeshesSomeOfThemIdle) {
  TestScene scene = three_meshes(with(kAll));
  scene.meshes[1].forces = weightless();
  set(scene.meshes[2].forces, {"evidence", "source", 0}), weight_of(scene.meshes[2].forces, ForceId::Gradient) = 0;
  scene.points.pop_back();
  expect_equal_bits(scene, 30, "one idle, one without a gradient and from its field");
  scene.meshes[0].forces = weightless();
  expect_equal_bits(scene, 30, "the first idle too");
}

TEST(EightVertices, EveryVoxelType) {
  PhantomSettings settings;
  settings.background = 20, settings.contrast = 80, settings.noise_sigma = 4, settings.size = 64;
  settings.type = VoxelType::Int16;
  const Volume integers = make_phantom("sphere", settings).image;
  for (VoxelType type : {VoxelType::Int16, VoxelType::Int8, VoxelType::UInt8, VoxelType::UInt16, VoxelType::Int32,
                         VoxelType::UInt32, VoxelType::Float32, VoxelType::Float64}) {
    TestScene scene = three_meshes(with(kAll));
    scene.volume = Volume(integers.geometry(), type);
    visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
      // Values that use every bit, and negative ones for signed types.
      const double scale = std::is_floating_point_v<T> ? 1.0 / 7 : sizeof(T) == 1 ? 1 : sizeof(T) == 2 ? 300 : 3e6;
      for (std::size_t k = 0; k < integers.geometry().voxel_count(); ++k)
        scene.volume.voxels<T>()[k] =
            static_cast<T>(scale * (integers.voxels<std::int16_t>()[k] - (std::is_signed_v<T> ? 50 : 0)));
    });
    for (TestMesh& mesh : scene.meshes) mesh.region = estimate_region(scene.volume, mesh.mesh, 20);
    expect_equal_bits(scene, 6, to_string(type));
    set(scene.meshes[0].forces, {"gradient", "object", 2});
    expect_equal_bits(scene, 6, std::string(to_string(type)) + ", dark");
  }
}

TEST(EightVertices, ThinVolumesWithNaNVoxelsAndLinesThatLeaveThem) {
  const Volume& full = phantom("sphere").image;
  for (const std::array<int, 3>& size : {std::array{1, 64, 64}, {64, 1, 64}, {64, 64, 1}, {1, 1, 1}, {2, 40, 30}}) {
    TestScene scene = three_meshes(with(kAll));
    VolumeGeometry geometry = full.geometry();
    geometry.size = size;
    scene.volume = Volume(geometry, VoxelType::Float32);
    for (std::size_t k = 0; k < geometry.voxel_count(); ++k)
      scene.volume.voxels<float>()[k] = k % 97 == 5 ? NAN : static_cast<float>(k * k % 211);
    // The meshes are centred in the volume, so that some search lines are inside and some are not.
    const Eigen::Vector3f move = geometry.centre_mm().cast<float>();
    for (TestMesh& mesh : scene.meshes) {
      for (Eigen::Vector3f& p : mesh.mesh.positions) p += move;
      mesh.field.clear();
    }
    scene.points.clear();
    expect_equal_bits(scene, 6,
                      std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]));
  }
}

TEST(EightVertices, FoldedAndDegenerateCells) {
  for (int kind = 0; kind < 4; ++kind) {
    TestScene scene = three_meshes(with(kAll));
    for (TestMesh& mesh : scene.meshes) {
      Positions& x = mesh.mesh.positions;
      const int n = static_cast<int>(x.size());
      for (int i = 3; i < n; i += 13) {
        const std::array<int, 3>& nb = mesh.mesh.neighbours[i];
        if (kind == 0) x[nb[1]] = x[nb[0]];                      // two neighbours coincide
        if (kind == 1) x[nb[2]] = 0.5f * (x[nb[0]] + x[nb[1]]);  // collinear neighbours
        if (kind == 2) x[nb[0]] = x[nb[1]] = x[nb[2]] = x[i];    // all four coincide
        if (kind == 3) x[i] = -0.5f * x[i];                      // moved through the surface
      }
    }
    expect_equal_bits(scene, 12, "kind " + std::to_string(kind));
  }
  TestScene points = three_meshes(with(kAll));
  for (TestMesh& mesh : points.meshes)
    for (Eigen::Vector3f& p : mesh.mesh.positions) p = {1, 2, 3};
  expect_equal_bits(points, 5, "each mesh a point");
}

TEST(EightVertices, AFailedStepIsUndoneAndNamesTheSameVertex) {
  for (const int vertex : {0, 5, 17, 79}) {
    TestScene scene = three_meshes(with({{"smoothing", "weight", 1}, {"shape_memory", "weight", 0.5f}}));
    scene.meshes[0].mesh.positions[vertex].x() = 3e20f;
    scene.simulation = simulation(1, 0.5f);
    expect_equal_bits(scene, 5, "far away: vertex " + std::to_string(vertex));
    const auto engine = make_cpu_engine(1);
    load(*engine, scene);
    const StepOutcome outcome = engine->step(5);
    EXPECT_TRUE(outcome.failure.has_value() || !outcome.cuts.empty());
    EXPECT_TRUE(all_finite(positions_of(*engine, scene)));
  }
  // A velocity that only the vertex itself reads.
  TestScene scene = three_meshes(with({{"attraction", "weight", 1}}));
  scene.meshes[2].previous = scene.meshes[2].mesh.positions;
  scene.meshes[2].previous[100].z() = std::numeric_limits<float>::quiet_NaN();
  scene.simulation = simulation(1, 0.5f);
  expect_equal_bits(scene, 5, "a NaN velocity");
}

}  // namespace
}  // namespace simplexseg
