// SPDX-License-Identifier: Apache-2.0
// Objects that spread into their surroundings, and large ones that do not (docs/adr/0046-objects-that-spread.md).
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "ellipsoid_scene.h"
#include "field/evidence_box.h"
#include "field/evidence_field.h"
#include "image/metrics.h"

namespace simplexseg {
namespace {

VoxelBox box_of(int size) { return {{0, 0, 0}, {size, size, size}}; }

TEST(VolumeInBoxes, IncreasesWithoutAConstantVolumeAreGrowth) {
  VolumeInBoxes volumes;
  for (const int n : {1, 2, 4, 8, 16}) EXPECT_FALSE(volumes.add(100.0 * n, box_of(n)));
}

TEST(VolumeInBoxes, AnIncreaseAfterAConstantVolumeIsALeak) {
  VolumeInBoxes volumes;
  const double mm3[] = {100, 140, 146, 143, 160, 189};
  for (int n = 0; n < 6; ++n) EXPECT_FALSE(volumes.add(mm3[n], box_of(n + 1))) << n;
  EXPECT_TRUE(volumes.add(190, box_of(7))) << "more than 30% above 146";
  EXPECT_EQ(volumes.constant_in(), box_of(4)) << "the last box in which the volume was constant";
}

TEST(VolumeInBoxes, ASecondVolumeInTheSameBoxReplacesTheFirst) {
  VolumeInBoxes volumes;
  EXPECT_FALSE(volumes.add(100, box_of(1)));
  EXPECT_FALSE(volumes.add(102, box_of(1)));
  EXPECT_FALSE(volumes.add(150, box_of(2))) << "the volume was not constant over a growth";
}

TEST(ThinObjects, AreTubesPlatesAndWhatFillsLittleOfItsBox) {
  const Eigen::Vector3d mm(1, 1, 2);
  const auto is_thin_in = [&](const std::array<int, 3>& size, double fill) {
    const double cells = static_cast<double>(size[0]) * size[1] * size[2];
    return is_thin(fill * 2 * cells, {{0, 0, 0}, size}, mm);
  };
  EXPECT_FALSE(is_thin_in({20, 20, 10}, 0.5)) << "a cube";
  EXPECT_TRUE(is_thin_in({20, 20, 10}, 0.19)) << "a shell";
  EXPECT_TRUE(is_thin_in({10, 10, 21}, 0.8)) << "a tube of 10 x 10 x 42 mm";
  EXPECT_FALSE(is_thin_in({10, 10, 19}, 0.8));
  EXPECT_TRUE(is_thin_in({20, 20, 1}, 1)) << "a plate of 20 x 20 x 2 mm";
  EXPECT_FALSE(is_thin_in({20, 20, 2}, 1));
}

VolumeGeometry grid_of(std::array<int, 3> size) {
  VolumeGeometry geometry;
  geometry.size = size;
  return geometry;
}

TEST(SpreadingObject, AStraightTubeOfManyBallsIsNotStopped) {
  const auto tube = [](const Eigen::Vector3d& p) {
    return std::hypot(p.x() - 15, p.y() - 15) <= 3 && p.z() >= 10 && p.z() <= 190 ? 100.0 : 0.0;
  };
  const Scene scene = scene_of(grid_of({31, 31, 200}), tube, 10);
  EvidenceField field(scene.image);
  field.update(std::vector{inside({15, 15, 100}, 2.5)});
  EXPECT_FALSE(field.report().stopped);
  EXPECT_FALSE(field.report().leaks);
  EXPECT_GT(dice(scene.truth, field.object()), 0.9);
}

TEST(SpreadingObject, IsStoppedIfItHasMoreBallsThanTheLimit) {
  const auto ellipsoid = [](const Eigen::Vector3d& p) {
    const Eigen::Vector3d d = p - Eigen::Vector3d(20, 20, 60);
    return d.cwiseQuotient(Eigen::Vector3d(12, 12, 36)).norm() <= 1 ? 100.0 : 0.0;
  };
  const Scene scene = scene_of(grid_of({41, 41, 121}), ellipsoid, 10);
  const auto solve = [&](double max_volume) {
    EvidenceSettings settings;
    settings.max_volume = max_volume;
    EvidenceField field(scene.image, run_serially(), settings);
    field.update(std::vector{inside({20, 20, 60}, 10)});
    return std::pair(field.report().stopped, dice(scene.truth, field.object()));
  };
  const auto [stopped, small] = solve(0.5);  // the object has 5 balls
  EXPECT_TRUE(stopped);
  EXPECT_LT(small, 0.9);
  const auto [stopped_later, whole] = solve(6);
  EXPECT_FALSE(stopped_later);
  EXPECT_GT(whole, 0.95);
}

TEST(SpreadingObject, IsNotOneWhoseExtentTheUserHasMarked) {
  const auto ellipsoid = [](const Eigen::Vector3d& p) {
    const Eigen::Vector3d d = p - Eigen::Vector3d(20, 20, 60);
    return d.cwiseQuotient(Eigen::Vector3d(12, 12, 46)).norm() <= 1 ? 100.0 : 0.0;
  };
  const Scene scene = scene_of(grid_of({41, 41, 121}), ellipsoid, 10);
  EvidenceSettings settings;
  settings.max_volume = 1.2;  // the object has 4 balls of its radius, and 1.8 of a sixth of its extent
  EvidenceField field(scene.image, run_serially(), settings);
  const Mark seed = inside({20, 20, 60}, 10), above = inside({20, 20, 103}, 2), below = inside({20, 20, 17}, 2);
  field.update(std::vector{seed});
  EXPECT_TRUE(field.report().stopped);
  field.update(std::vector{seed, above, below});
  EXPECT_FALSE(field.report().stopped);
  EXPECT_GT(dice(scene.truth, field.object()), 0.95);
}

TEST(SpreadingObject, IsReportedIfItIsCompleteAndFarAboveTheLimit) {
  const auto ball = [](const Eigen::Vector3d& p) {
    return (p - Eigen::Vector3d::Constant(30)).norm() <= 12 ? 100.0 : 0.0;
  };
  const Scene scene = scene_of(grid_of({61, 61, 61}), ball, 10);
  const auto report = [&](double max_volume) {
    EvidenceSettings settings;
    settings.max_volume = max_volume;
    settings.margin_share = 1;  // the first box contains the object
    EvidenceField field(scene.image, run_serially(), settings);
    field.update(std::vector{inside({30, 30, 30}, 10)});
    EXPECT_GT(dice(scene.truth, field.object()), 0.95);
    return field.report();
  };
  const EvidenceField::Report reported = report(0.6);  // the object has 1.7 balls
  EXPECT_TRUE(reported.leaks);
  EXPECT_FALSE(reported.stopped);
  EXPECT_FALSE(report(1).leaks);
}

TEST(MarkedExtent, IsThatOfAllMarksThatAreNotOutside) {
  Mark boundary = inside({0, 30, 0}, 2), far_outside = inside({500, 0, 0}, 5);
  boundary.kind = MarkKind::Boundary, far_outside.kind = MarkKind::Outside;
  EXPECT_EQ(marked_extent(std::vector{far_outside}), 0);
  EXPECT_EQ(marked_extent(std::vector{inside({1, 2, 3}, 4)}), 8);
  EXPECT_EQ(marked_extent(std::vector{inside({0, 0, 10}, 4), far_outside, boundary}), 36);
}

}  // namespace
}  // namespace simplexseg
