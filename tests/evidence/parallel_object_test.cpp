// SPDX-License-Identifier: Apache-2.0
#include "evidence/parallel/object.h"

#include <gtest/gtest.h>

#include <cmath>

namespace simplexseg {
namespace {

struct Case {
  VoxelBox box;
  std::vector<float> field;
  std::vector<Constraint> known;
  explicit Case(const std::array<int, 3>& size)
      : box{{3, 4, 5}, size}, field(box.voxel_count()), known(box.voxel_count(), Constraint::None) {}
};

/// Checks that the object equals the CPU's bit for bit; returns it.
FieldObject expect_same(const Case& c) {
  const FieldObject expected = object_of_field(c.field, c.known, c.box, run_in_turn());
  const SerialExecutor executor;
  ParallelObject<SerialExecutor> object(executor, c.box);
  std::vector<std::uint8_t> voxels(c.box.voxel_count(), 7);
  for (int time = 0; time < 2; ++time) {  // the second time with the buffers of the first
    const auto found = object.find(c.field.data(), c.known.data(), voxels.data());
    EXPECT_EQ(voxels, expected.voxels);
    EXPECT_EQ(found.around, expected.around);
    EXPECT_DOUBLE_EQ(found.border_share, expected.border_share);
  }
  return expected;
}

/// Ball with two holes, one of which contains an outside mark, and another ball without a mark.
TEST(ParallelObject, HolesWithoutAnOutsideMarkAreFilled) {
  Case c({40, 30, 30});
  const auto within = [&](double x, double y, double z, double r, const auto& change) {
    for (int k = 0, v = 0; k < 30; ++k)
      for (int j = 0; j < 30; ++j)
        for (int i = 0; i < 40; ++i, ++v)
          if (std::hypot(i - x, j - y, k - z) <= r) change(v);
  };
  const auto set = [&](float p) { return [&c, p](int v) { c.field[v] = p; }; };
  within(14, 14, 14, 11, set(1));
  within(9, 14, 14, 2, set(0));
  within(19, 14, 14, 2, set(0));
  within(34, 14, 14, 4, set(1));
  within(14, 8, 14, 1, [&](int v) { c.known[v] = Constraint::Inside; });
  within(19, 14, 14, 0, [&](int v) { c.known[v] = Constraint::Outside; });
  const FieldObject object = expect_same(c);
  EXPECT_EQ(object.voxels[c.box.offset(9, 14, 14)], 1);
  EXPECT_EQ(object.voxels[c.box.offset(19, 14, 14)], 0);
  EXPECT_EQ(object.voxels[c.box.offset(34, 14, 14)], 0);
  EXPECT_EQ(object.around, (VoxelBox{{6, 7, 8}, {23, 23, 23}}));
}

/// Single path that winds through the whole box, which gives the longest trees.
TEST(ParallelObject, FollowsALongPath) {
  Case c({31, 31, 7});
  for (int k = 0; k < 7; ++k)
    for (int j = 0; j < 31; ++j)
      for (int i = 0; i < 31; ++i) {
        const bool flat = k % 2 == 0, line = j % 2 == 0, turn = i == (j / 2 % 2 == 0 ? 30 : 0);
        const bool up = j == (k / 2 % 2 == 0 ? 30 : 0) && i == 0;
        c.field[c.box.offset(i, j, k)] = (flat && (line || turn)) || (!flat && up) ? 1.0f : 0.0f;
      }
  c.known[0] = Constraint::Inside;
  EXPECT_EQ(expect_same(c).around.size, (std::array{31, 31, 7}));
}

}  // namespace
}  // namespace simplexseg
