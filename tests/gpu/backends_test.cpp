// SPDX-License-Identifier: Apache-2.0
// Compares CPU and CUDA, which run the same kernels, for each force alone and to a given tolerance. Compilers contract
// and order float sums differently, so the bits differ. A search with equal samples may have different results, so the
// scene is smooth.
#include "support/engine_fixture.h"

#include <cstdio>

namespace simplexseg {
namespace {

constexpr double kOneStepTolerance = 1e-4;    // mm
constexpr double kManyStepsTolerance = 0.05;  // mm, after 200 steps
// The texture unit interpolates with weights of 8 bits, which shifts edges by up to some hundredths of a voxel.
constexpr double kFilteredOneStep = 0.02, kFilteredManySteps = 0.1;

TestScene scene_with_force(ForceId force) {
  TestScene scene = busy_scene();
  weight_of(scene.meshes[0].forces, force) = 0.5f;
  // |grad I| of the trilinear interpolant jumps from voxel to voxel; the derivative along the normal does not.
  set(scene.meshes[0].forces, {"gradient", "object", 1});
  // Without smoothing, the discrete evidence of the region roughens the surface until even a last bit has an effect.
  if (force == ForceId::Evidence) weight_of(scene.meshes[0].forces, ForceId::Smoothing) = 0.5f;
  scene.simulation = limited(1, 0.9f, 3);
  return scene;
}

void compare(VolumeSampling sampling, double one_step, double many_steps) {
  if (!cuda_unavailable_reason().empty())
    GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  for (const ForceInfo& force : force_list()) {
    const TestScene scene = scene_with_force(force.id);
    for (int steps : {1, 200}) {
      const double distance =
          largest_distance(run(*make_cuda_engine(sampling), scene, steps), run(*make_cpu_engine(), scene, steps));
      EXPECT_LE(distance, steps == 1 ? one_step : many_steps) << force.name << " after " << steps << " steps";
      ::testing::Test::RecordProperty(std::string(force.name) + "_" + std::to_string(steps), std::to_string(distance));
      std::printf("[ distance ] %s after %d steps: %.2g mm\n", force.name, steps, distance);
    }
  }
}

TEST(CpuAgainstCuda, EachForceOnItsOwnFetched) {
  compare(VolumeSampling::Fetched, kOneStepTolerance, kManyStepsTolerance);
}
TEST(CpuAgainstCuda, EachForceOnItsOwnLinear) {
  compare(VolumeSampling::Linear, kOneStepTolerance, kManyStepsTolerance);
}
TEST(CpuAgainstCuda, EachForceOnItsOwnFiltered) {
  compare(VolumeSampling::Filtered, kFilteredOneStep, kFilteredManySteps);
}

TEST(CpuAgainstCuda, EvidenceFromAField) {
  if (!cuda_unavailable_reason().empty())
    GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  for (const int level : {3, 7}) {
    TestScene scene = level == 3 ? scene_with_force(ForceId::Evidence) : busy_scene(level);
    scene.meshes[0].forces =
        with({{"smoothing", "weight", 0.5f}, {"evidence", "weight", 0.5f}, {"evidence", "source", 0}});
    scene.simulation = limited(1, 0.9f, 3);
    for (int steps : {1, level == 3 ? 200 : 2}) {
      const double distance = largest_distance(run(*make_cuda_engine(VolumeSampling::Fetched), scene, steps),
                                               run(*make_cpu_engine(), scene, steps));
      EXPECT_LE(distance, steps == 1 ? kOneStepTolerance : kManyStepsTolerance) << level << ", " << steps << " steps";
      std::printf("[ distance ] evidence from a field, level %d, after %d steps: %.2g mm\n", level, steps, distance);
    }
  }
}

constexpr ForceId kSearches[] = {ForceId::Gradient, ForceId::IntensityProfile, ForceId::Evidence};

TestScene many_vertices(ForceId force) {
  TestScene scene = busy_scene(7);  // 327,680
  weight_of(scene.meshes[0].forces, force) = 0.5f;
  weight_of(scene.meshes[0].forces, ForceId::Attraction) = 0.5f;
  set(scene.meshes[0].forces, {"gradient", "object", 1});
  scene.simulation = limited(1, 0.9f, 1);
  return scene;
}

/// Compares poses of many vertices. Some vertices have two equal samples, between which rounding decides.
void expect_near(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b, ForceId force) {
  const char* const name = force_list()[static_cast<int>(force)].name;
  std::size_t far = 0;
  for (std::size_t i = 0; i < a.size(); ++i) far += (a[i] - b[i]).norm() > 1e-3f;
  EXPECT_LE(far, a.size() / 10000) << name;
  EXPECT_LE(largest_distance(a, b), 0.01) << name;
}

/// Tests searches by single threads; with fewer vertices several lanes share a search.
TEST(CpuAgainstCuda, ManyVertices) {
  if (!cuda_unavailable_reason().empty())
    GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  for (const ForceId force : kSearches) {
    const TestScene scene = many_vertices(force);
    expect_near(run(*make_cuda_engine(VolumeSampling::Fetched), scene, 2), run(*make_cpu_engine(), scene, 2), force);
  }
}

TEST(CpuAgainstCuda, ManyVerticesAreInsensitiveToRounding) {
  for (const ForceId force : kSearches) {
    const TestScene scene = many_vertices(force);
    TestScene other = scene;
    other.meshes[0].mesh = with_noise(scene.meshes[0].mesh, 2e-6, 7);
    expect_near(run(*make_cpu_engine(), other, 2), run(*make_cpu_engine(), scene, 2), force);
  }
}

/// Justifies the tolerances of CpuAgainstCuda: a change of the last bits of the input changes the result by less.
TEST(CpuAgainstCuda, TheSceneIsInsensitiveToRounding) {
  for (const ForceInfo& force : force_list()) {
    const TestScene scene = scene_with_force(force.id);
    TestScene other = scene;
    other.meshes[0].mesh = with_noise(scene.meshes[0].mesh, 2e-6, 7);
    EXPECT_LE(largest_distance(run(*make_cpu_engine(), other, 1), run(*make_cpu_engine(), scene, 1)), kOneStepTolerance)
        << force.name;
    EXPECT_LE(largest_distance(run(*make_cpu_engine(), other, 200), run(*make_cpu_engine(), scene, 200)),
              kManyStepsTolerance)
        << force.name;
  }
}

TEST(Backends, AnUnavailableBackendHasAReason) {
  EXPECT_STREQ(make_engine(Backend::Cpu).engine->backend(), "cpu");
  EXPECT_TRUE(make_engine(Backend::Cpu).note.empty());
  const EngineChoice choice = make_engine(Backend::Auto);
  if (cuda_unavailable_reason().empty()) {
    EXPECT_STREQ(choice.engine->backend(), "cuda");
  } else {
    EXPECT_STREQ(choice.engine->backend(), "cpu");
    EXPECT_NE(choice.note.find(cuda_unavailable_reason()), std::string::npos);
    EXPECT_ANY_THROW(make_engine(Backend::Cuda));
  }
}

}  // namespace
}  // namespace simplexseg
