// SPDX-License-Identifier: Apache-2.0
// Object and surface of a field by the parallel version on the serial executor, compared with the CPU version.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "evidence/box_image.h"
#include "evidence/field_voxel.h"
#include "evidence/parallel/before.h"
#include "evidence/parallel/object.h"
#include "evidence/parallel/surface.h"
#include "evidence/quantile.h"
#include "evidence/surface_layer.h"

namespace simplexseg {
namespace {

const SerialExecutor executor;

/// Smoothed noise: blobs with holes, several components, some at the sides of the box.
std::vector<float> blobs(const BoxGrid& grid, unsigned seed, double voxels) {
  std::mt19937 random(seed);
  std::vector<float> field(grid.count());
  for (float& f : field) f = static_cast<float>(random()) / 4294967296.0f;
  smooth(field, grid, {voxels, voxels, voxels}, run_in_turn());
  std::vector<float> sorted = field;
  const float low = quantile(sorted, 0.02), high = quantile(sorted, 0.98);
  for (float& f : field) f = std::clamp((f - low) / (high - low), 0.0f, 1.0f);
  return field;
}

std::vector<Constraint> some_known(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Constraint> known(count);
  for (Constraint& k : known) {
    const unsigned r = random() % 400;
    k = r < 2   ? Constraint::Inside
        : r < 4 ? Constraint::Outside
        : r < 5 ? Constraint::FarBorder
        : r < 6 ? Constraint::NotFinite
                : Constraint::None;
  }
  return known;
}

TEST(ParallelObject, EqualsTheCpusObject) {
  int parts = 0, filled = 0;
  for (const std::array<int, 3>& size :
       {std::array{40, 33, 21}, std::array{64, 40, 1}, std::array{1, 30, 30}, std::array{7, 9, 50}})
    for (unsigned seed = 0; seed < 8; ++seed) {
      const VoxelBox box{{3, -2, 5}, size};
      const BoxGrid grid{size};
      const std::vector<float> field = blobs(grid, seed, seed % 2 ? 0.7 : 1.6);
      const std::vector<Constraint> known = some_known(grid.count(), seed + 100);
      const FieldObject cpu = object_of_field(field, known, box, run_in_turn());
      std::vector<std::uint8_t> voxels(grid.count());
      ParallelObject<SerialExecutor> finder(executor, box);
      for (int again = 0; again < 2; ++again) {
        const auto found = finder.find(field.data(), known.data(), voxels.data());
        ASSERT_EQ(voxels, cpu.voxels) << seed;
        EXPECT_EQ(found.around, cpu.around) << seed;
        EXPECT_DOUBLE_EQ(found.border_share, cpu.border_share) << seed;
      }
      for (int v = 0; v < grid.count(); ++v) {
        parts += field[v] > 0.5f && !voxels[v];
        filled += field[v] <= 0.5f && voxels[v];
      }
    }
  EXPECT_GT(parts, 100) << "something was dropped";
  EXPECT_GT(filled, 100) << "something was filled";
}

TEST(ParallelObject, IsEmptyForAnEmptyField) {
  const VoxelBox box{{0, 0, 0}, {8, 8, 8}};
  const std::vector<float> field(512, 0.9f);
  const std::vector<Constraint> known(512, Constraint::None);
  std::vector<std::uint8_t> voxels(512, 7);
  const auto found = ParallelObject<SerialExecutor>(executor, box).find(field.data(), known.data(), voxels.data());
  EXPECT_EQ(voxels, std::vector<std::uint8_t>(512, 0));
  EXPECT_EQ(found.around.voxel_count(), 0u);
}

TEST(ParallelSmooth, EqualsTheCpu) {
  const BoxGrid grid{{21, 18, 9}};
  for (const std::array<double, 3>& sigma :
       {std::array{1.3, 0.7, 0.1}, std::array{4.0, 4.0, 4.0}, std::array{0.5, 2.0, 1.0}}) {
    SmoothedFields<SerialExecutor, 2> fields(executor, grid);
    std::vector<float> a = blobs(grid, 1, 0.5), b = blobs(grid, 2, 0.5);
    executor.upload<float>(a, fields.data(0));
    executor.upload<float>(b, fields.data(1));
    fields.smooth(sigma);
    smooth(a, grid, sigma, run_in_turn());
    smooth(b, grid, sigma, run_in_turn());
    for (int v = 0; v < grid.count(); ++v) {
      ASSERT_NEAR(fields.data(0)[v], a[v], 2e-6f);
      ASSERT_NEAR(fields.data(1)[v], b[v], 2e-6f);
    }
  }
}

template <class Value>
std::optional<float> quantile_on(int count, const Value& value, double share, int least_count = 1) {
  const auto selected = select_quantile(executor, count, value, share, least_count);
  const auto found = received<Selected>(executor, executor.fetch(selected.data(), 1));
  return found.found ? std::optional(found.value_or(0)) : std::nullopt;
}

TEST(ParallelSelect, IsTheValueOfThatRank) {
  std::mt19937 random(5);
  for (const int count : {1, 2, 3, 100, 5000}) {
    std::vector<float> values(count);
    for (float& x : values)
      x = random() % 7 == 0 ? 0.0f : std::ldexp(static_cast<float>(random() % 100000), -int(random() % 30));
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      std::vector<float> copy = values;
      const float expected = quantile(copy, share);
      EXPECT_EQ(quantile_on(
                    count, [&](int v) { return values[v]; }, share)
                    .value(),
                expected);
      EXPECT_EQ(quantile_on(
                    2 * count, [&](int v) { return v % 2 ? -1.0f : values[v / 2]; }, share)
                    .value(),
                expected);
    }
  }
  EXPECT_FALSE(quantile_on(
      10, [](int) { return -1.0f; }, 0.5));
  EXPECT_FALSE(quantile_on(
      10, [](int) { return 1.0f; }, 0.5, 11));
  EXPECT_TRUE(quantile_on(
      10, [](int) { return 1.0f; }, 0.5, 10));
}

/// Ball in noise and a field whose surface is displaced.
TEST(ParallelSurface, EqualsTheCpusSurface) {
  double moved = 0;
  for (const std::array<double, 3>& spacing : {std::array{1.0, 1.0, 1.0}, std::array{0.8, 0.8, 3.0}})
    for (const double offset : {0.0, 0.6}) {
      const VoxelBox box{{2, 3, 4}, {44, 44, spacing[2] > 2 ? 16 : 44}};
      const BoxGrid grid{box.size};
      std::vector<float> image(grid.count()), field(grid.count());
      const std::vector<float> noise = blobs(grid, 3, 0.4);
      std::vector<Constraint> known = some_known(grid.count(), 9);
      for (int v = 0; v < grid.count(); ++v) {
        const double x = (v % 44 - 21) * spacing[0], y = (v / 44 % 44 - 21) * spacing[1],
                     z = (v / grid.plane() - 0.5 * box.size[2]) * spacing[2], r = std::sqrt(x * x + y * y + z * z);
        image[v] = (r < 12 ? 0.6f : 0.3f) + 0.15f * noise[v];
        field[v] = static_cast<float>(1 / (1 + std::exp(1.2 * (r - 10.6 + 0.8 * std::sin(x)))));
        if (r < 9 ? known[v] == Constraint::Outside : known[v] == Constraint::Inside) known[v] = Constraint::None;
      }
      known[(grid.count() + grid.plane() + 44) / 2] = Constraint::Inside;
      const EvidenceSettings settings;
      const FieldObject object = object_of_field(field, known, box, run_in_turn());
      ASSERT_GT(object.around.voxel_count(), 1000u);
      // Previous field with another surface, and two new marks: one at the surface, one deep.
      std::vector<std::uint8_t> before;
      BandTerms terms{offset, 0, {}};
      if (offset != 0) {
        for (int v = 0; v < grid.count(); ++v) before.push_back(as_before(field[v > 1 ? v - 2 : v]));
        terms.temporal_weight = 0.7;
        for (const float x : {10.0f, -11.0f})
          terms.moves.push_back({{static_cast<float>(21 * spacing[0]) + x, static_cast<float>(21 * spacing[1]),
                                  static_cast<float>(0.5 * box.size[2] * spacing[2])},
                                 x > 0 ? 1.5f : 0.0f,
                                 x > 0 ? 0.0f : 3.0f});
      }
      std::vector<float> cpu = field, parallel = field;
      refine_in_narrow_band(cpu, object, known, image, before, box, spacing, terms, settings, run_in_turn());
      refine_in_narrow_band(executor, parallel.data(), object.voxels.data(), object.around, known.data(), image.data(),
                            before.empty() ? nullptr : before.data(), box, spacing, terms, settings);
      int other_side = 0;
      for (int v = 0; v < grid.count(); ++v) {
        EXPECT_NEAR(parallel[v], cpu[v], 0.02) << v;
        other_side += (parallel[v] > 0.5f) != (cpu[v] > 0.5f);
        moved += std::fabs(cpu[v] - field[v]) > 0.2;
      }
      EXPECT_LE(other_side, 2);
      const double expected =
          end_expected_dice(executor, begin_expected_dice(executor, grid.count(), field.data(), object.voxels.data()));
      double right = 0, all = 0, taken = 0;
      for (int v = 0; v < grid.count(); ++v)
        all += field[v], right += object.voxels[v] ? field[v] : 0, taken += object.voxels[v];
      EXPECT_NEAR(expected, 2 * right / (taken + all), 1e-6);
    }
  EXPECT_GT(moved, 500);
}

TEST(ParallelBefore, FindsTheNearestVoxelOfTheOtherSide) {
  VolumeGeometry geometry;
  geometry.size = {40, 40, 20};
  geometry.spacing_mm = {1, 1, 2.5};
  const VoxelBox box{{4, 5, 2}, {30, 28, 16}};
  std::vector<std::uint8_t> before(box.voxel_count(), 1);
  for (int k = 4; k < 12; ++k)
    for (int j = 8; j < 20; ++j)
      for (int i = 6; i < 25; ++i) before[box.offset(i, j, k)] = 255;
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3d& index :
       {Eigen::Vector3d(15, 17, 9), Eigen::Vector3d(5, 6, 3), Eigen::Vector3d(9.6, 13, 6), Eigen::Vector3d(29, 30, 17)})
    places.push_back(geometry.world_from_index() * index);
  const std::vector<std::uint8_t> object = was_object(executor, geometry, box, before.data(), places);
  const std::vector<FieldSolver::Before> at = before_at(executor, geometry, box, before.data(), places);
  int inside = 0;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const bool in = before[nearest_voxel(geometry, box, places[p])] > kPreviousThreshold;
    const std::vector<float> square = squared_distances(geometry, box, {&places[p], 1}, run_in_turn());
    float least = 1e12f;
    for (std::size_t v = 0; v < before.size(); ++v)
      if ((before[v] > kPreviousThreshold) != in) least = std::min(least, square[v]);
    EXPECT_EQ(object[p] != 0, in) << p;
    EXPECT_EQ(at[p].object, in) << p;
    EXPECT_NEAR(at[p].depth_mm, std::sqrt(least), 1e-3) << p;
    inside += in;
  }
  EXPECT_EQ(inside, 2);
}

}  // namespace
}  // namespace simplexseg
