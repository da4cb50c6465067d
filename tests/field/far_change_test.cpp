// SPDX-License-Identifier: Apache-2.0
// Changes of the field far from new marks.
#include "field/parallel/far_change.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ellipsoid_scene.h"
#include "field/evidence_field.h"
#include "field/robot_user.h"

namespace simplexseg {
namespace {

TEST(FarChange, IsReducedFromTwoToFourDepths) {
  const BoxGrid grid{{60, 7, 5}};
  const int n = grid.count();
  std::vector<float> field(n, 0.8f);
  std::vector<std::uint8_t> before(n, to_8_bits(0.2f));
  std::vector<Constraint> known(n);
  const int row = (2 * 7 + 3) * 60;  // through the marks
  before[row + 50] = 0;
  known[row + 51] = Constraint::Inside;
  known[row + 52] = Constraint::OtherObject;
  const std::vector<NewMarkDepth> marks{{{0, 9, 4}, 5}, {{104, 9, 4}, 1}};
  const CpuFieldExecutor executor;
  executor.each_cell(grid,
                     DampFarChange{marks.data(), 2, {2, 3, 2}, 3, 0.25f, before.data(), known.data(), field.data()});
  const float old = 0.2f;
  for (int i = 0; i < 50; ++i) {
    const double depths = std::min(2.0 * i / 5, std::abs(2.0 * i - 104));
    const double share = 1 - 0.75 * std::clamp(0.5 * depths - 1, 0.0, 1.0);
    EXPECT_NEAR(field[row + i], old + share * 0.6, 3e-3) << i;
  }
  EXPECT_EQ(field[row + 50], 0.8f) << "nothing is known of the previous field";
  EXPECT_EQ(field[row + 51], 0.8f) << "inside mark";
  EXPECT_EQ(field[row + 52], 0.8f) << "mark of another object";
}

TEST(FarChange, WithShare0CellsOutsideThePreviousBoxAreBackground) {
  const BoxGrid grid{{30, 3, 3}};
  std::vector<float> field(grid.count(), 0.8f);
  std::vector<std::uint8_t> before(grid.count(), 0);
  const std::vector<Constraint> known(grid.count());
  const std::vector<NewMarkDepth> marks{{{0, 1, 1}, 5}};
  CpuFieldExecutor().each_cell(
      grid, DampFarChange{marks.data(), 1, {1, 1, 1}, 2, 0, before.data(), known.data(), field.data()});
  const int row = (1 * 3 + 1) * 30;
  EXPECT_EQ(field[row + 6], 0.8f) << "near the mark";
  EXPECT_EQ(field[row + 14], 0) << "2.8 depths away";
}

/// Object masks before and after a third mark on an ellipsoid in noise; the mark is local or not.
std::array<Mask, 2> masks_around_a_mark(const Scene& scene, Mark last, bool local) {
  std::vector<Mark> marks{inside({0, 0, 0}, 8), outside({24, 9, 0}, 1.8)};
  EvidenceField field(scene.image);
  for (std::size_t m = 1; m <= marks.size(); ++m) field.update(std::span(marks).first(m));
  Mask before = field.object();
  last.local = local;
  marks.push_back(last);
  field.update(marks);
  return {std::move(before), field.object()};
}

/// Number of voxels that differ and are farther than a distance from a place.
int count_far_changes(const std::array<Mask, 2>& masks, const Eigen::Vector3d& place, double mm) {
  const VolumeGeometry& g = masks[0].geometry;
  int far = 0;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i) {
        const std::size_t v = (static_cast<std::size_t>(k) * g.size[1] + j) * g.size[0] + i;
        if (masks[0].voxels[v] != masks[1].voxels[v])
          far += (g.world_from_index() * Eigen::Vector3d(i, j, k) - place).norm() > mm;
      }
  return far;
}

TEST(FarChange, ALocalMarkChangesOnlyWhatIsNearIt) {
  const Scene scene = ellipsoid(72, 1, {26, 12, 12}, 60);
  const Mark cut = outside({20, -4, 3}, 1.8);
  const std::array<Mask, 2> plain = masks_around_a_mark(scene, cut, false),
                            local = masks_around_a_mark(scene, cut, true);
  ASSERT_EQ(plain[0].voxels, local[0].voxels);
  EXPECT_GT(count_far_changes(plain, cut.position_mm, 25), 0) << "the test scene must show the difference";
  EXPECT_EQ(count_far_changes(local, cut.position_mm, 25), 0);
  const auto at = [&](const Mask& mask) {
    const Eigen::Vector3d index = mask.geometry.index_from_world() * cut.position_mm;
    return mask
        .voxels[scene.image.offset(static_cast<int>(std::lround(index[0])), static_cast<int>(std::lround(index[1])),
                                   static_cast<int>(std::lround(index[2])))];
  };
  EXPECT_EQ(at(local[0]), 1);
  EXPECT_EQ(at(local[1]), 0) << "the mark itself acts";
}

TEST(FarChange, OfAnObjectIsLessThanWithoutTheReduction) {
  const Scene scene = ellipsoid(72, 1, {26, 12, 12}, 60);
  const std::vector<Mark> marks{inside({0, 0, 0}, 8), outside({24, 9, 0}, 1.8), outside({25, -8, 3}, 1.8)};
  const Eigen::Vector3d click = scene.image.geometry().index_from_world() * marks.back().position_mm;
  const auto changed = [&](double far_change) {
    EvidenceSettings settings;
    settings.far_change = far_change;
    EvidenceField field(scene.image, run_serially(), settings);
    field.update(std::span(marks).first(1));
    field.update(std::span(marks).first(2));
    const Mask before = field.object();
    field.update(marks);
    return reach_of_click(before, field.object(),
                          {static_cast<int>(std::lround(click[0])), static_cast<int>(std::lround(click[1])),
                           static_cast<int>(std::lround(click[2]))},
                          3, 16000)
        .far_share;
  };
  const double all = changed(0), reduced = changed(1);
  EXPECT_GT(all, 0) << "the scene shows nothing";
  EXPECT_LT(reduced, 0.7 * all);
}

}  // namespace
}  // namespace simplexseg
