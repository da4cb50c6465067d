// SPDX-License-Identifier: Apache-2.0
// Common properties of all forces. A new force is tested automatically once it is in the list of forces.
#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <set>

#include "forces/force_list.h"
#include "forces/region_model.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class EveryForceTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(EveryForceTest);

using Names = std::set<std::string>;
Names arrays_of(const Engine& engine) {
  Names names;
  for (const Engine::AllocatedArray& array : engine.allocated_arrays()) names.insert(array.name);
  return names;
}
Names kernels_of(const Engine& engine) {
  Names names;
  for (const Engine::KernelCount& kernel : engine.kernel_counts())
    if (kernel.launches > 0) names.insert(kernel.name);
  return names;
}
Names difference(const Names& a, const Names& b) {
  Names rest;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::inserter(rest, rest.end()));
  return rest;
}

/// Busy scene with a single force; attraction also needs an image force to fade.
TestScene scene_of(ForceId force) {
  TestScene scene = busy_scene();
  scene.simulation = simulation(1, 0.9f, 2);
  weight_of(scene.meshes[0].forces, force) = 0.4f;
  if (force == ForceId::Attraction) weight_of(scene.meshes[0].forces, ForceId::Gradient) = 0.4f;
  return scene;
}

/// Values of a parameter other than `base`: the ends and the middle of its range, or all choices.
std::vector<float> alternatives(const ParameterInfo& info, float base) {
  std::vector<float> values;
  if (info.kind == ParameterKind::Choice) {
    for (float v = info.minimum; v <= info.maximum; ++v) values.push_back(v);
  } else {
    values = {info.minimum, info.maximum, 0.5f * (info.minimum + info.maximum), 2 * base, 0.5f * base, 0.1f * base};
  }
  std::erase_if(values, [&](float v) { return v == base || v < info.minimum || v > info.maximum; });
  return values;
}

TEST_P(EveryForceTest, ActsInTheBusyScene) {
  for (const ForceInfo& force : force_list()) {
    const TestScene scene = scene_of(force.id);
    EXPECT_GT(largest_distance(run(scene, 5), scene.meshes[0].mesh.positions), 0.05) << force.name;
  }
}

TEST_P(EveryForceTest, EveryParameterChangesTheResult) {
  for (const ForceInfo& force : force_list()) {
    for (std::size_t k = 0; k < force.parameters.size(); ++k) {
      const ParameterInfo& info = force.parameters[k];
      TestScene base = scene_of(force.id);
      if (force.id == ForceId::Evidence && k == EvidenceForce::hold)  // needs a field
        set(base.meshes[0].forces, {"evidence", "source", 0});
      const Positions expected = run(base, 7);
      const float value = base.meshes[0].forces.values[static_cast<int>(force.id)][k];
      double most = 0, least = 1e9;
      for (float other : alternatives(info, value)) {
        TestScene scene = base;
        scene.meshes[0].forces.values[static_cast<int>(force.id)][k] = other;
        if (force.id == ForceId::IntensityProfile)  // recorded again when their length changes
          scene.meshes[0].profiles = profile_reference_of(make_sphere({0.3, -0.2, 0.1}, kPhantomRadius, 3),
                                                          scene.volume, scene.meshes[0].forces);
        const double change = largest_distance(run(scene, 7), expected);
        most = std::max(most, change), least = std::min(least, change);
      }
      EXPECT_GT(most, 1e-3) << force.name << "." << info.name << " has no effect";
      if (info.kind == ParameterKind::Choice) {
        EXPECT_GT(least, 1e-4) << force.name << "." << info.name << ": two choices do the same";
      }
    }
  }
}

TEST_P(EveryForceTest, WeightZeroChangesNothingAndAllocatesNothing) {
  TestScene none = busy_scene();
  const auto bare = make_engine();
  simplexseg::run(*bare, none, 5);
  EXPECT_TRUE(same_bits(positions_of(*bare, none), none.meshes[0].mesh.positions)) << "without forces nothing moves";
  for (const ForceInfo& force : force_list()) {
    // Arrays and kernels that the force adds when it acts alone ...
    TestScene alone = busy_scene();
    weight_of(alone.meshes[0].forces, force.id) = 0.4f;
    const auto acting = make_engine();
    simplexseg::run(*acting, alone, 5);
    const Names arrays = difference(arrays_of(*acting), arrays_of(*bare)),
                kernels = difference(kernels_of(*acting), kernels_of(*bare));
    // ... are absent when only the other forces act; none of its parameters matters.
    TestScene rest = busy_scene();
    rest.simulation = simulation(1, 0.9f, 2);
    for (const ForceInfo& other : force_list())
      weight_of(rest.meshes[0].forces, other.id) = other.id == force.id ? 0.0f : 0.2f;
    const auto without = make_engine();
    const Positions expected = simplexseg::run(*without, rest, 5);
    for (const std::string& name : arrays)
      EXPECT_FALSE(arrays_of(*without).contains(name)) << force.name << " allocates " << name;
    for (const std::string& name : kernels)
      EXPECT_FALSE(kernels_of(*without).contains(name)) << force.name << " runs " << name;
    for (bool high : {false, true}) {
      TestScene other = rest;
      for (std::size_t k = 1; k < force.parameters.size(); ++k)
        other.meshes[0].forces.values[static_cast<int>(force.id)][k] =
            high ? force.parameters[k].maximum : force.parameters[k].minimum;
      EXPECT_TRUE(same_bits(run(other, 5), expected)) << force.name;
    }
    // Disabling the force between steps releases its arrays.
    std::vector<ForceParameters> off{weightless()};
    acting->set_parameters(off, alone.simulation);
    EXPECT_EQ(arrays_of(*acting), arrays_of(*bare)) << force.name;
  }
}

TEST_P(EveryForceTest, WeightZeroOfOneMeshWhileAnotherUsesTheForce) {
  for (const ForceInfo& force : force_list()) {
    TestScene alone = busy_scene();
    alone.simulation = simulation(1, 0.9f, 2);
    for (const ForceInfo& other : force_list())
      weight_of(alone.meshes[0].forces, other.id) = other.id == force.id ? 0.0f : 0.2f;
    TestScene pair = alone;
    pair.meshes.push_back(alone.meshes[0]);
    weight_of(pair.meshes[1].forces, force.id) = 0.5f;
    const Positions expected = run(alone, 10);
    Positions first = run(pair, 10);
    first.resize(expected.size());
    EXPECT_TRUE(same_bits(first, expected)) << force.name << " of the second mesh moves the first";
  }
}

TEST_P(EveryForceTest, MovesWithSceneAndVolume) {
  const Eigen::Affine3d motion =
      Eigen::Translation3d(31, -12, 7) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -0.5).normalized());
  for (const ForceInfo& force : force_list()) {
    const TestScene scene = scene_of(force.id);
    TestScene moved = scene;
    // Identical voxels with a moved geometry.
    VolumeGeometry geometry = scene.volume.geometry();
    geometry.origin_mm = motion * geometry.origin_mm;
    geometry.direction = motion.linear() * geometry.direction;
    moved.volume = Volume(geometry, scene.volume.type());
    std::copy_n(static_cast<const std::byte*>(scene.volume.data()), scene.volume.bytes(),
                static_cast<std::byte*>(moved.volume.data()));
    for (Eigen::Vector3f& p : moved.meshes[0].mesh.positions) p = (motion * p.cast<double>()).cast<float>();
    for (EnginePoint& p : moved.points) p.position_mm = motion * p.position_mm;
    Positions expected = run(scene, 4);
    for (Eigen::Vector3f& p : expected) p = (motion * p.cast<double>()).cast<float>();
    EXPECT_LT(largest_distance(run(moved, 4), expected), 2e-3) << force.name;
  }
}

TEST_P(EveryForceTest, AFlatImageMovesNothing) {
  for (ForceId force : {ForceId::Gradient, ForceId::IntensityProfile, ForceId::Evidence})
    for (float choice : {0.0f, 1.0f}) {
      TestScene scene = busy_scene();
      scene.volume = phantom("flat").image;
      TestMesh& m = scene.meshes[0];
      weight_of(m.forces, force) = 1;
      set(m.forces, {"gradient", "object", choice});
      set(m.forces, {"intensity_profile", "measure", choice});
      m.profiles = profile_reference_of(m.mesh, scene.volume, m.forces);
      m.region = estimate_region(scene.volume, m.mesh, 20);
      EXPECT_TRUE(same_bits(run(scene, 5), m.mesh.positions)) << force_list()[static_cast<int>(force)].name;
    }
}

TEST_P(EveryForceTest, SamplesOutsideTheVolumeAreIgnored) {
  // A mesh crosses the border of a flat volume, which must not act as an edge.
  for (ForceId force : {ForceId::Gradient, ForceId::IntensityProfile})
    for (float choice : {0.0f, 1.0f}) {
      TestScene scene = busy_scene();
      scene.volume = phantom("flat").image;
      TestMesh& m = scene.meshes[0];
      m.mesh = make_sphere({25, 0, 0}, 15, 3);
      m.shape.clear();
      weight_of(m.forces, force) = 1;
      set(m.forces, {"gradient", "object", choice});
      m.profiles = profile_reference_of(m.mesh, scene.volume, m.forces);
      EXPECT_TRUE(same_bits(run(scene, 5), m.mesh.positions)) << force_list()[static_cast<int>(force)].name;
    }
  // Results of every force are finite with half of the mesh outside, and with all of it.
  for (double x : {30.0, 500.0}) {
    TestScene scene = busy_scene(3, 10);
    TestMesh& m = scene.meshes[0];
    for (Eigen::Vector3f& p : m.mesh.positions) p[0] += static_cast<float>(x);
    for (const ForceInfo& force : force_list()) weight_of(m.forces, force.id) = 0.2f;
    scene.simulation = limited(1, 0.9f, 3);
    EXPECT_TRUE(all_finite(run(scene, 50)));
  }
}

}  // namespace
}  // namespace simplexseg
