// SPDX-License-Identifier: Apache-2.0
// CPU against CUDA: the same kernels, each force on its own, to a stated tolerance. Compilers contract and order sums
// of floats differently, so the bits differ; a search that ties may go the other way, so the scene is smooth.
#include "engine_fixture.h"

namespace simplexseg {
namespace {

constexpr double kOneStepTolerance = 1e-4;    // mm
constexpr double kManyStepsTolerance = 0.05;  // mm, after 200 steps

TestScene scene_of(ForceId force) {
  TestScene scene = busy_scene();
  weight_of(scene.meshes[0].forces, force) = 0.5f;
  // |grad I| of the trilinear interpolant jumps from voxel to voxel; the derivative along the normal does not.
  set(scene.meshes[0].forces, {"gradient", "object", 1});
  // Alone, the region's discrete evidence roughens the surface until a last bit shows: beside smoothing, as it is
  // meant.
  if (force == ForceId::Region) weight_of(scene.meshes[0].forces, ForceId::Smoothing) = 0.5f;
  scene.simulation = limited(1, 0.9f, 3);
  return scene;
}

TEST(CpuAgainstCuda, EachForceOnItsOwn) {
  if (!why_no_cuda().empty()) GTEST_SKIP() << "skipped: no CUDA device (" << why_no_cuda() << ")";
  for (const ForceInfo& force : force_list()) {
    const TestScene scene = scene_of(force.id);
    EXPECT_LE(largest_distance(run(*make_cuda_engine(), scene, 1), run(*make_cpu_engine(), scene, 1)),
              kOneStepTolerance)
        << force.name;
    EXPECT_LE(largest_distance(run(*make_cuda_engine(), scene, 200), run(*make_cpu_engine(), scene, 200)),
              kManyStepsTolerance)
        << force.name;
  }
}

/// That the tolerances of CpuAgainstCuda are fair: a change of the last bits of the input changes the result by less.
TEST(CpuAgainstCuda, TheSceneForgivesRounding) {
  for (const ForceInfo& force : force_list()) {
    const TestScene scene = scene_of(force.id);
    TestScene other = scene;
    other.meshes[0].mesh = with_noise(scene.meshes[0].mesh, 2e-6, 7);
    EXPECT_LE(largest_distance(run(*make_cpu_engine(), other, 1), run(*make_cpu_engine(), scene, 1)), kOneStepTolerance)
        << force.name;
    EXPECT_LE(largest_distance(run(*make_cpu_engine(), other, 200), run(*make_cpu_engine(), scene, 200)),
              kManyStepsTolerance)
        << force.name;
  }
}

TEST(Backends, WhatCannotBeHadSaysWhy) {
  EXPECT_STREQ(make_engine(Backend::Cpu).engine->backend(), "cpu");
  EXPECT_TRUE(make_engine(Backend::Cpu).note.empty());
  const EngineChoice choice = make_engine(Backend::Auto);
  if (why_no_cuda().empty()) {
    EXPECT_STREQ(choice.engine->backend(), "cuda");
  } else {
    EXPECT_STREQ(choice.engine->backend(), "cpu");
    EXPECT_NE(choice.note.find(why_no_cuda()), std::string::npos);
    EXPECT_ANY_THROW(make_engine(Backend::Cuda));
  }
}

}  // namespace
}  // namespace simplexseg
