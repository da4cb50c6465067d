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
