// SPDX-License-Identifier: Apache-2.0
// Features of the network of all marks (field/mark_view.h), as the field records them.
#include <gtest/gtest.h>

#include <cmath>

#include "field/evidence_field.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

constexpr int kDistance = 3, kToOutside = 5, kEdgesIn = 6, kEdgeZScore = 8, kMost = 11, kMean = 12, kFirst = 13,
              kReach = 15, kWall = 19, kMarks = 20;

/// Image of 60 x 40 x 40 voxels of 1 mm, bright where `bright` is true, with little noise.
template <class Bright>
Volume image_of(const Bright& bright) {
  VolumeGeometry geometry;
  geometry.size = {60, 40, 40};
  Volume label(geometry, VoxelType::UInt8);
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 60; ++i) label.voxels<std::uint8_t>()[label.offset(i, j, k)] = bright(i, j, k);
  PhantomSettings settings;
  settings.noise_sigma = 3;
  return image_of_label(label, 1.0, settings);
}

double from(double x, int i, int j, int k) { return std::hypot(i - x, j - 20.0, k - 20.0); }

Mark inside(double x, double radius) { return {MarkKind::Inside, {x, 20, 20}, radius, {0, 0, 0}}; }
Mark outside(double x, double radius) { return {MarkKind::Outside, {x, 20, 20}, radius, {0, 0, 0}}; }

/// Features on the middle line of the image.
class OnMiddleLine {
 public:
  OnMiddleLine(const Volume& image, const std::vector<Mark>& marks) : field_(image, run_serially(), on_voxels()) {
    field_.record_features(true);
    field_.update(marks);
    EXPECT_EQ(field_.features().size, field_.box().size);
    EXPECT_TRUE(field_.features().update.empty());
  }
  float operator()(int feature, int i) const {
    const VoxelBox& box = field_.box();
    return field_.features().marks[feature][box.offset(i - box.first[0], 20 - box.first[1], 20 - box.first[2])];
  }

 private:
  /// Blocks of one voxel.
  static EvidenceSettings on_voxels() {
    EvidenceSettings settings;
    settings.blocks_per_scale = 1e9;
    return settings;
  }

  EvidenceField field_;
};

TEST(MarkFeatures, DistancesAreInReachesOfTheObject) {
  const Volume ball = image_of([](int i, int j, int k) { return from(25, i, j, k) < 10; });
  const OnMiddleLine small(ball, {inside(25, 6)}), right(ball, {inside(25, 10)});
  EXPECT_GT(small(kReach, 25), std::log(1.3));  // a small seed sees the wall
  EXPECT_FLOAT_EQ(right(kReach, 25), 0);
  EXPECT_NEAR(right(kDistance, 35), std::log(1 + 0.1), 1e-4);
  EXPECT_NEAR(right(kDistance, 25), std::log(0.1), 1e-4);
  EXPECT_NEAR(small(kDistance, 35), right(kDistance, 35), 0.25);
  EXPECT_GT(right(kWall, 25), 5);  // its surroundings differ from it
}

TEST(MarkFeatures, ALineToAVoxelMeetsOtherIntensities) {
  const Volume slab = image_of([](int i, int, int) { return i < 30 || i > 33; });
  const OnMiddleLine at(slab, {inside(20, 7)});
  EXPECT_LT(at(kMost, 27), 3);
  EXPECT_EQ(at(kFirst, 27), 1);
  EXPECT_GT(at(kMost, 31), 5);
  EXPECT_GT(at(kEdgeZScore, 31), 5);
  EXPECT_LT(at(kEdgeZScore, 36), 3);  // same intensity as the object, but behind a wall
  EXPECT_GT(at(kMost, 36), 5);
  EXPECT_LT(at(kFirst, 36), 0.7);
  EXPECT_GT(at(kMean, 36), at(kMean, 27));
  EXPECT_GT(at(kEdgesIn, 36), at(kEdgesIn, 27) + 1);
}

TEST(MarkFeatures, OutsideMarksCount) {
  const Volume ball = image_of([](int i, int j, int k) { return from(25, i, j, k) < 10; });
  const OnMiddleLine one(ball, {inside(25, 8)}), two(ball, {inside(25, 8), outside(40, 2)});
  EXPECT_FLOAT_EQ(one(kMarks, 25), 0);
  EXPECT_FLOAT_EQ(two(kMarks, 25), std::log(2.0f));
  EXPECT_LT(two(kToOutside, 38), one(kToOutside, 38) - 1);
}

}  // namespace
}  // namespace simplexseg
