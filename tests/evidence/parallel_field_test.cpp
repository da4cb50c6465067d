// SPDX-License-Identifier: Apache-2.0
// Parallel evidence field on the serial executor and on a CUDA device, compared with the CPU version.
#include "evidence/parallel/field_solver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "ellipsoid_scene.h"
#include "evidence/evidence_field.h"
#include "gpu/backend.h"
#include "image/metrics.h"

namespace simplexseg {
namespace {

std::unique_ptr<FieldSolver> make_serial_field_solver(const Volume& volume, const RunJobs& run,
                                                      const EvidenceSettings& settings) {
  return std::make_unique<ParallelFieldSolver<SerialExecutor>>(volume, run, settings);
}

Mark boundary(const Eigen::Vector3d& at, const Eigen::Vector3d& outward) {
  return {MarkKind::Boundary, at, 1.8, outward};
}

class ParallelField : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "cuda" && !cuda_unavailable_reason().empty())
      GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  }
  static MakeFieldSolver make() {
    return GetParam() == "cuda" ? MakeFieldSolver(make_cuda_field_solver) : MakeFieldSolver(make_serial_field_solver);
  }
  static EvidenceField field_of(const Scene& scene, const EvidenceSettings& settings = {}) {
    return EvidenceField(scene.image, run_in_turn(), settings, make());
  }

  /// Scale of the scenes: the serial executor takes a thousand times as long as a device.
  static double scale() { return GetParam() == "cuda" ? 1 : 0.55; }
  static int wide(int voxels) { return static_cast<int>(scale() * voxels); }

  /// Updates both fields mark by mark, from the seed on, and compares them after each mark.
  static void compare(const Scene& scene, const std::vector<Mark>& marks, std::span<const Mark> others = {},
                      double least_dice = 0.985, double most_difference = 0.01) {
    EvidenceField cpu(scene.image), parallel = field_of(scene);
    for (std::size_t count = 1; count <= marks.size(); ++count) {
      cpu.update({marks.data(), count}, others);
      parallel.update({marks.data(), count}, others);
      ASSERT_EQ(parallel.box(), cpu.box()) << count;
      EXPECT_NEAR(parallel.report().beta, cpu.report().beta, 1e-3 * cpu.report().beta) << count;
      EXPECT_EQ(parallel.report().leaks, cpu.report().leaks) << count;
      EXPECT_EQ(parallel.report().growths, cpu.report().growths) << count;
      EXPECT_NEAR(parallel.report().expected_dice, cpu.report().expected_dice, 0.01) << count;
      EXPECT_GE(dice(parallel.object(), cpu.object()), least_dice) << count;
      double sum = 0;
      for (std::size_t v = 0; v < cpu.probability().size(); ++v)
        sum += std::fabs(parallel.probability()[v] - cpu.probability()[v]);
      EXPECT_LE(sum / static_cast<double>(cpu.probability().size()), most_difference) << count;
    }
  }
};

TEST_P(ParallelField, EqualsTheCpuAfterEachOfManyMarks) {
  const double s = scale();
  const Scene scene = ellipsoid(wide(56), 1, s * Eigen::Vector3d(18, 13, 10), 30);
  compare(scene, {inside({0, 0, 0}, 6 * s), inside({15 * s, 0, 0}, 1.8), outside({0, 15 * s, 0}, 2.5 * s),
                  boundary({0, 0, 10 * s}, {0, 0, 1}), outside({21 * s, 0, 0}, 3 * s), inside({0, -11 * s, 1}, 1.2)});
}
TEST_P(ParallelField, EqualsTheCpuInThickSlices) {
  compare(ellipsoid(60, 4, {20, 16, 22}, 25), {inside({2, 1, 0}, 8), outside({0, 20, 4}, 2), inside({-17, 0, 0}, 2)});
}
TEST_P(ParallelField, EqualsTheCpuWhereTheBoxGrowsAndTheVolumeCutsTheObject) {
  const double s = scale();
  compare(ellipsoid(wide(64), 1, s * Eigen::Vector3d(26, 40, 20), 15),
          {inside({-10 * s, -20 * s, 0}, 5 * s), outside({28 * s, 0, 0}, 2)});
}
TEST_P(ParallelField, EqualsTheCpuInASingleSlice) {
  compare(ellipsoid(48, 40, {15, 12, 30}, 20), {inside({0, 0, 0}, 5), outside({18, 0, 0}, 2)});
}
TEST_P(ParallelField, HandlesOtherObjectsAndVoxelsThatAreNotFinite) {
  const double s = scale();
  const int width = wide(48);
  Scene scene = ellipsoid(width, 1, s * Eigen::Vector3d(16, 12, 12), 20);
  for (int j = 0; j < width; ++j)
    for (int i = wide(30); i < wide(34); ++i) scene.image.voxels<float>()[scene.image.offset(i, j, wide(20))] = NAN;
  const std::vector<Mark> others{inside({-12 * s, 0, 0}, 4 * s)};
  compare(scene, {inside({4 * s, 0, 0}, 5 * s), inside({14 * s, 0, 0}, 1.8)}, others);
  EvidenceField with = field_of(scene), without = field_of(scene);
  const std::vector<Mark> seed{inside({4 * s, 0, 0}, 5 * s)};
  with.update(seed, others);
  without.update(seed);
  const Mask a = with.object(), b = without.object();
  const Eigen::Affine3d world = scene.image.geometry().world_from_index();
  int shared = 0, beside = 0;
  for (std::size_t v = 0; v < a.voxels.size(); ++v) {
    const auto at = static_cast<int>(v);
    const Eigen::Vector3d index(at % width, at / width % width, at / (width * width));
    const bool in_other = (world * index - others[0].position_mm).norm() < others[0].radius_mm;
    shared += a.voxels[v] && in_other;
    beside += b.voxels[v] && in_other;
  }
  EXPECT_EQ(shared, 0);
  EXPECT_GT(beside, 0);
}

TEST_P(ParallelField, IsReproducible) {
  const double s = scale();
  const Scene scene = ellipsoid(wide(56), 1, s * Eigen::Vector3d(18, 13, 10), 40);
  const std::vector<Mark> marks{inside({0, 0, 0}, 6 * s), inside({15 * s, 0, 0}, 1.8), outside({0, 15 * s, 0}, 2.5)};
  std::vector<std::vector<float>> fields;
  for (int run = 0; run < (GetParam() == "cuda" ? 5 : 2); ++run) {
    EvidenceField field = field_of(scene);
    for (std::size_t count = 1; count <= marks.size(); ++count) field.update({marks.data(), count});
    fields.emplace_back(field.probability().begin(), field.probability().end());
    EXPECT_EQ(fields.back(), fields.front());
  }
}

TEST_P(ParallelField, ARemovedMarkHasNoEffect) {
  const Scene scene = ellipsoid(30, 1, {10, 8, 7}, 25);
  const std::vector<Mark> seed{inside({0, 0, 0}, 4)}, more{seed[0], outside({7, 0, 0}, 2)};
  EvidenceField field = field_of(scene);
  field.update(seed);
  const Mask before = field.object();
  field.update(more);
  EXPECT_LT(dice(field.object(), before), 0.99);
  field.update(seed);
  EXPECT_GT(dice(field.object(), before), 0.99);
}

TEST_P(ParallelField, ReportsAnIncreasingFraction) {
  const Scene scene = ellipsoid(30, 1, {10, 8, 7}, 25);
  EvidenceField field = field_of(scene);
  std::vector<Mark> marks{inside({0, 0, 0}, 4)};
  for (int update = 0; update < 2; ++update) {
    std::vector<float> fractions{0};
    field.update(marks, {}, [&](float fraction) {
      EXPECT_GT(fraction, fractions.back());
      fractions.push_back(fraction);
    });
    EXPECT_GT(fractions.size(), 5u);  // constraints, prior, features, walker, surface
    EXPECT_GT(fractions.back(), 0.9f);
    EXPECT_LT(fractions.back(), 1.0f);
    marks.push_back(outside({7, 0, 0}, 2));
  }
}

TEST_P(ParallelField, TheRadiusOfAMarkEqualsTheCpus) {
  const Scene scene = ellipsoid(32, 1, {11, 8, 7});
  EvidenceField cpu(scene.image), parallel = field_of(scene);
  const std::vector<Mark> seed{inside({0, 0, 0}, 5)};
  cpu.update(seed);
  parallel.update(seed);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 3), Eigen::Vector3d(13, 0, 0), Eigen::Vector3d(0, 7, 0)})
    EXPECT_NEAR(parallel.brush_mm(MarkKind::Outside, at), cpu.brush_mm(MarkKind::Outside, at), 0.5) << at.transpose();
  EXPECT_GT(parallel.bytes(), parallel.box().voxel_count() * 20);
}

struct LeftOut {
  const char* name;
  void (*change)(EvidenceSettings&);
};

TEST_P(ParallelField, EveryPartCanBeSwitchedOff) {
  const Scene scene = ellipsoid(28, 1, {9, 7, 6}, 40);
  const std::vector<Mark> marks{
      inside({0, 0, 0}, 4), outside({8, 0, 0}, 1), {MarkKind::Boundary, {0, 6, 0}, 1, {0, 1, 0}}};
  const auto field_with = [&](void (*change)(EvidenceSettings&)) {
    EvidenceSettings settings;
    change(settings);
    EvidenceField field = field_of(scene, settings);
    field.update({marks.data(), 1});
    field.update(marks);
    return std::vector<float>(field.probability().begin(), field.probability().end());
  };
  const std::vector<float> whole = field_with([](EvidenceSettings&) {});
  for (const LeftOut& part :
       {LeftOut{"appearance", [](EvidenceSettings& s) { s.use_appearance = false; }},
        LeftOut{"geodesic", [](EvidenceSettings& s) { s.use_geodesic = false; }},
        LeftOut{"random walk", [](EvidenceSettings& s) { s.use_random_walk = false; }},
        LeftOut{"memory", [](EvidenceSettings& s) { s.memory = false; }},
        LeftOut{"far memory", [](EvidenceSettings& s) { s.far_memory = 0; }},
        LeftOut{"expected-Dice threshold", [](EvidenceSettings& s) { s.expected_dice_threshold = false; }},
        LeftOut{"surface", [](EvidenceSettings& s) { s.surface_layer = 0; }},
        LeftOut{"surface offset", [](EvidenceSettings& s) { s.surface_offset = 0; }},
        LeftOut{"surface memory", [](EvidenceSettings& s) { s.surface_memory = 0; }},
        LeftOut{"surface pull", [](EvidenceSettings& s) { s.surface_pull = 0; }},
        LeftOut{"sharpness", [](EvidenceSettings& s) { s.sharpness = 0; }},
        LeftOut{"prior", [](EvidenceSettings& s) { s.prior_pull = 0; }},
        LeftOut{"smoothing", [](EvidenceSettings& s) { s.field_smoothing = 0; }},
        LeftOut{"blocks", [](EvidenceSettings& s) { s.least_reach = 2; }},
        LeftOut{"smoother image", [](EvidenceSettings& s) { s.image_smoothing = 2; }}})
    EXPECT_TRUE(field_with(part.change) != whole) << part.name;
}

INSTANTIATE_TEST_SUITE_P(Executors, ParallelField, ::testing::Values("serial", "cuda"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace simplexseg
