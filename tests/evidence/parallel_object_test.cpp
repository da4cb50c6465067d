// SPDX-License-Identifier: Apache-2.0
#include "evidence/parallel/object.h"

#include <gtest/gtest.h>

#include <cmath>

namespace simplexseg {
namespace {

struct Case {
  VoxelBox box;
  std::vector<float> field;
  std::vector<Known> known;
  explicit Case(const std::array<int, 3>& size)
      : box{{3, 4, 5}, size}, field(box.voxel_count()), known(box.voxel_count(), Known::Nothing) {}
};

/// That the object is, to a bit, the one of the CPU; returns it.
FieldObject expect_same(const Case& c) {
  const FieldObject expected = object_of_field(c.field, c.known, c.box, run_in_turn());
  const OneByOne executor;
  ParallelObject<OneByOne> object(executor, c.box);
  std::vector<std::uint8_t> voxels(c.box.voxel_count(), 7);
  for (int time = 0; time < 2; ++time) {  // the second time what the first left is there
    const auto found = object.find(c.field.data(), c.known.data(), voxels.data());
    EXPECT_EQ(voxels, expected.voxels);
    EXPECT_EQ(found.around, expected.around);
    EXPECT_DOUBLE_EQ(found.border_share, expected.border_share);
  }
  return expected;
}

/// A ball with two hollows, one of which holds an outside mark, and another ball without a mark.
TEST(ParallelObject, HolesAreFilledButThoseWithAnOutsideMark) {
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
  within(14, 8, 14, 1, [&](int v) { c.known[v] = Known::Inside; });
  within(19, 14, 14, 0, [&](int v) { c.known[v] = Known::Outside; });
  const FieldObject object = expect_same(c);
  EXPECT_EQ(object.voxels[c.box.offset(9, 14, 14)], 1);
  EXPECT_EQ(object.voxels[c.box.offset(19, 14, 14)], 0);
  EXPECT_EQ(object.voxels[c.box.offset(34, 14, 14)], 0);
  EXPECT_EQ(object.around, (VoxelBox{{6, 7, 8}, {23, 23, 23}}));
}

/// One way that winds through the whole box: the longest trees.
TEST(ParallelObject, FollowsALongWay) {
  Case c({31, 31, 7});
  for (int k = 0; k < 7; ++k)
    for (int j = 0; j < 31; ++j)
      for (int i = 0; i < 31; ++i) {
        const bool flat = k % 2 == 0, line = j % 2 == 0, turn = i == (j / 2 % 2 == 0 ? 30 : 0);
        const bool up = j == (k / 2 % 2 == 0 ? 30 : 0) && i == 0;
        c.field[c.box.offset(i, j, k)] = (flat && (line || turn)) || (!flat && up) ? 1.0f : 0.0f;
      }
  c.known[0] = Known::Inside;
  EXPECT_EQ(expect_same(c).around.size, (std::array{31, 31, 7}));
}

}  // namespace
}  // namespace simplexseg
