// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/object.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/quantile.h"
#include "field/box_image.h"
#include "references.h"

namespace simplexseg {
namespace {

struct Case {
  VoxelBox box;
  std::vector<float> field;
  std::vector<Constraint> constraints;
  explicit Case(const std::array<int, 3>& size, const std::array<int, 3>& first = {3, 4, 5})
      : box{first, size}, field(box.voxel_count()), constraints(box.voxel_count(), Constraint::None) {}
};

/// Object by flood fill: of the field from inside marks, then of the rest from the sides and from excluding marks.
FieldObject reference(const Case& c) {
  const BoxGrid grid{c.box.size};
  std::vector<std::uint8_t> set(c.field.size()), start(c.field.size()), near(c.field.size());
  each_index(grid, [&](int, int, int, int v) {
    set[v] = c.field[v] > 0.5f;
    start[v] = c.constraints[v] == Constraint::Inside;
  });
  const std::vector<std::uint8_t> connected = flooded(set, start, grid);
  each_index(grid, [&](int i, int j, int k, int v) {
    const int at[3]{i, j, k};
    int to_side = 1000;
    for (int a = 0; a < 3; ++a)
      if (grid.size[a] > 1) to_side = std::min({to_side, at[a], grid.size[a] - 1 - at[a]});
    set[v] = !connected[v];
    start[v] = to_side == 0 || c.constraints[v] == Constraint::Outside || c.constraints[v] == Constraint::OtherObject;
    near[v] = to_side <= 4;
  });
  FieldObject object{flooded(set, start, grid), {}, 0, 0};
  std::array<int, 3> low = grid.size, high{-1, -1, -1};
  double of_object = 0, all = 0;
  each_index(grid, [&](int i, int j, int k, int v) {
    object.voxels[v] = !object.voxels[v];
    const bool is = object.voxels[v] != 0;
    object.count += is;
    of_object += is && near[v];
    all += near[v];
    const int at[3]{i, j, k};
    for (int a = 0; is && a < 3; ++a) low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
  });
  for (int a = 0; a < 3 && object.count > 0; ++a)
    object.bounds.first[a] = c.box.first[a] + low[a], object.bounds.size[a] = high[a] - low[a] + 1;
  object.border_share = of_object / all;
  return object;
}

/// Checks that the object equals the reference in any order of the jobs; returns it.
FieldObject expect_reference(const Case& c) {
  const FieldObject expected = reference(c);
  std::vector<JobOrder> orders = job_orders();
  orders.push_back({"in turn", run_serially()});
  for (const JobOrder& order : orders) {
    const CpuFieldExecutor executor(order.run);
    ParallelObject<CpuFieldExecutor> object(executor, c.box);
    std::vector<std::uint8_t> voxels(c.box.voxel_count(), 7);
    for (int time = 0; time < 2; ++time) {  // the second time with the buffers of the first
      const auto found = object.find(c.field.data(), c.constraints.data(), voxels.data());
      EXPECT_EQ(voxels, expected.voxels) << order.name;
      EXPECT_EQ(found.bounds, expected.bounds) << order.name;
      EXPECT_EQ(found.count, expected.count) << order.name;
      EXPECT_DOUBLE_EQ(found.border_share, expected.border_share) << order.name;
    }
  }
  const FieldObject object = object_of_field(c.field, c.constraints, c.box);
  EXPECT_EQ(object.voxels, expected.voxels);
  EXPECT_EQ(object.bounds, expected.bounds);
  EXPECT_EQ(object.count, expected.count);
  EXPECT_DOUBLE_EQ(object.border_share, expected.border_share);
  return object;
}

/// Ball with two holes, one of which contains an outside mark, and another ball without a mark.
TEST(FieldObject, HolesWithoutAnOutsideMarkAreFilled) {
  Case c({40, 30, 30});
  const auto within = [&](double x, double y, double z, double r, const auto& change) {
    each_index({c.box.size}, [&](int i, int j, int k, int v) {
      if (std::hypot(i - x, j - y, k - z) <= r) change(v);
    });
  };
  const auto set = [&](float p) { return [&c, p](int v) { c.field[v] = p; }; };
  within(14, 14, 14, 11, set(1));
  within(9, 14, 14, 2, set(0));
  within(19, 14, 14, 2, set(0));
  within(34, 14, 14, 4, set(1));
  within(14, 8, 14, 1, [&](int v) { c.constraints[v] = Constraint::Inside; });
  within(19, 14, 14, 0, [&](int v) { c.constraints[v] = Constraint::Outside; });
  const FieldObject object = expect_reference(c);
  EXPECT_EQ(object.voxels[c.box.offset(9, 14, 14)], 1);
  EXPECT_EQ(object.voxels[c.box.offset(19, 14, 14)], 0);
  EXPECT_EQ(object.voxels[c.box.offset(34, 14, 14)], 0);
  EXPECT_EQ(object.bounds, (VoxelBox{{6, 7, 8}, {23, 23, 23}}));
}

/// Single path that winds through the whole box, which gives the longest trees.
TEST(FieldObject, FollowsALongPath) {
  Case c({31, 31, 7});
  each_index({c.box.size}, [&](int i, int j, int k, int v) {
    const bool flat = k % 2 == 0, line = j % 2 == 0, turn = i == (j / 2 % 2 == 0 ? 30 : 0);
    const bool up = j == (k / 2 % 2 == 0 ? 30 : 0) && i == 0;
    c.field[v] = (flat && (line || turn)) || (!flat && up) ? 1.0f : 0.0f;
  });
  c.constraints[0] = Constraint::Inside;
  EXPECT_EQ(expect_reference(c).bounds.size, (std::array{31, 31, 7}));
}

/// Smoothed noise: blobs with holes, several components, some at the sides of the box.
void fill_with_blobs(Case& c, unsigned seed, double voxels) {
  const BoxGrid grid{c.box.size};
  std::mt19937 random(seed);
  for (float& f : c.field) f = static_cast<float>(random()) / 4294967296.0f;
  smooth(c.field, grid, {voxels, voxels, voxels}, run_serially());
  std::vector<float> sorted = c.field;
  const float low = quantile(sorted, 0.02), high = quantile(sorted, 0.98);
  for (float& f : c.field) f = std::clamp((f - low) / (high - low), 0.0f, 1.0f);
  for (Constraint& k : c.constraints) {
    const unsigned r = random() % 400;
    k = r < 2   ? Constraint::Inside
        : r < 4 ? Constraint::Outside
        : r < 5 ? Constraint::FarBorder
        : r < 6 ? Constraint::NotFinite
        : r < 7 ? Constraint::OtherObject
                : Constraint::None;
  }
}

TEST(FieldObject, EqualsAFloodFillInBlobs) {
  int dropped = 0, filled = 0;
  for (const std::array<int, 3>& size :
       {std::array{40, 33, 21}, std::array{64, 40, 1}, std::array{1, 30, 30}, std::array{7, 9, 50}})
    for (unsigned seed = 0; seed < 8; ++seed) {
      Case c(size, {3, -2, 5});
      fill_with_blobs(c, seed, seed % 2 ? 0.7 : 1.6);
      const FieldObject object = expect_reference(c);
      for (std::size_t v = 0; v < c.field.size(); ++v) {
        dropped += c.field[v] > 0.5f && !object.voxels[v];
        filled += c.field[v] <= 0.5f && object.voxels[v];
      }
    }
  EXPECT_GT(dropped, 100);
  EXPECT_GT(filled, 100);
}

TEST(FieldObject, IsEmptyWithoutAnInsideMark) {
  Case c({8, 8, 8}, {0, 0, 0});
  std::fill(c.field.begin(), c.field.end(), 0.9f);
  const FieldObject object = expect_reference(c);
  EXPECT_EQ(object.voxels, std::vector<std::uint8_t>(512));
  EXPECT_EQ(object.count, 0u);
  EXPECT_EQ(object.bounds.voxel_count(), 0u);
}

TEST(FieldObject, ClosesAHoleInASingleSlice) {
  Case c({20, 20, 1});
  for (int j = 4; j < 16; ++j)
    for (int i = 4; i < 16; ++i) c.field[20 * j + i] = i >= 8 && i < 11 && j >= 8 && j < 11 ? 0.0f : 1.0f;
  c.constraints[20 * 5 + 5] = Constraint::Inside;
  EXPECT_EQ(expect_reference(c).count, 144u);
}

}  // namespace
}  // namespace simplexseg
