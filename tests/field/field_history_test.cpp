// SPDX-License-Identifier: Apache-2.0
// Dependence of the evidence field on the order of marks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ellipsoid_scene.h"
#include "field/evidence_field.h"
#include "image/metrics.h"

namespace simplexseg {
namespace {

TEST(EvidenceField, FreshMarksChangeNearVoxelsMoreThanFarOnes) {
  const Scene scene = ellipsoid(64, 1, {22, 9, 9}, 60);
  const std::vector<Mark> first{inside({-8, 0, 0}, 7)};
  std::vector<Mark> second = first;
  second.push_back(outside({-20, 3, 0}, 2));
  const auto change = [&](const EvidenceSettings& settings, double x) {
    EvidenceField field(scene.image, run_serially(), settings);
    field.update(first);
    const Mask before = field.object();
    field.update(second);
    const Mask after = field.object();
    int changed = 0;
    for (int k = 0; k < 64; ++k)
      for (int j = 0; j < 64; ++j)
        for (int i = 0; i < 64; ++i)
          if ((i - 31.5 > x) == (x > 0) && std::fabs(i - 31.5) > std::fabs(x))
            changed += before.voxels[scene.image.offset(i, j, k)] != after.voxels[scene.image.offset(i, j, k)];
    return changed;
  };
  EvidenceSettings usual;
  usual.band_half_width = 0;  // which each mark changes as a whole
  EvidenceSettings forgets = usual, far_forgets = usual, far_holds = usual;
  forgets.memory = false;
  far_forgets.far_memory = 0;
  far_holds.far_memory = 1;
  const int near = change(usual, -15), far = change(usual, 5);  // the far part has three times as many voxels
  EXPECT_GT(near, 50);
  EXPECT_LT(far, near / 2);
  EXPECT_NE(change(forgets, -15), near);
  EXPECT_LT(change(far_holds, 5), change(far_forgets, 5));
}

/// Clicks that all enlarge the object move its whole surface outwards, clicks that all shrink it inwards. Clicks that
/// agree with the field, or lie deep in a wrong part, do not move the whole surface.
TEST(EvidenceField, ConsistentClicksMoveTheWholeSurface) {
  const Scene scene = ellipsoid(48, 1, {11, 11, 11}, 60);
  EvidenceSettings without_offset;
  without_offset.band_offset = 0;
  // Voxels gained by the offset, on the side of the ball without clicks.
  const auto gain = [&](const std::vector<Mark>& clicks) {
    long long gained = 0;
    EvidenceField shifted(scene.image), fixed(scene.image, run_serially(), without_offset);
    std::vector<Mark> marks{inside({0, 0, 0}, 9)};
    shifted.update(marks);
    fixed.update(marks);
    for (const Mark& click : clicks) {
      marks.push_back(click);
      shifted.update(marks);
      fixed.update(marks);
    }
    const Mask shifted_object = shifted.object(), fixed_object = fixed.object();
    for (int k = 0; k < 48; ++k)
      for (int j = 0; j < 48; ++j)
        for (int i = 0; i < 22; ++i) {
          const std::size_t v = scene.image.offset(i, j, k);
          gained += static_cast<int>(shifted_object.voxels[v]) - static_cast<int>(fixed_object.voxels[v]);
        }
    return gained;
  };
  EXPECT_EQ(gain({}), 0);
  EXPECT_EQ(gain({inside({8, 0, 0}, 1)}), 0);
  EXPECT_EQ(gain({outside({20, 0, 0}, 1)}), 0);
  EXPECT_EQ(gain({outside({5, 0, 0}, 1)}), 0);
  const auto larger = gain({inside({12, 0, 0}, 1), inside({10, 7, 0}, 1)});
  EXPECT_GT(larger, 15);
  EXPECT_GT(larger, gain({inside({12, 0, 0}, 1)}));
  // An inside mark lies in the middle of the wrong part, a boundary mark at its end.
  const auto boundary = [](double x) { return Mark{MarkKind::Boundary, {x, 0, 0}, 1, {1, 0, 0}}; };
  EXPECT_GT(gain({boundary(14)}), 0);
  EXPECT_EQ(gain({boundary(18)}), 0);
  const auto smaller = gain({outside({10, 0, 0}, 1), outside({8, 6, 0}, 1)});
  EXPECT_LT(smaller, -15);
}

/// A boundary mark measures the distance from the surface and moves the surface beside it; balls do not.
TEST(EvidenceField, OnlyBoundaryMarksMoveTheSurfaceBesideThem) {
  const Scene scene = ellipsoid(48, 1, {11, 11, 11}, 60);
  EvidenceSettings alone;
  alone.shift_weight = 0;
  // Voxels that the object gains by the pull of a boundary mark.
  const auto pulled = [&](const Mark& click) {
    EvidenceField pulls(scene.image), stays(scene.image, run_serially(), alone);
    std::vector<Mark> marks{inside({0, 0, 0}, 9)};
    pulls.update(marks);
    stays.update(marks);
    marks.push_back(click);
    pulls.update(marks);
    stays.update(marks);
    const auto voxels = [](const EvidenceField& field) {
      return std::ranges::count(field.object_in_box().voxels, std::uint8_t{1});
    };
    return voxels(pulls) - voxels(stays);
  };
  EXPECT_GT(pulled({MarkKind::Boundary, {14, 0, 0}, 1, {1, 0, 0}}), 0);
  EXPECT_LT(pulled({MarkKind::Boundary, {9, 0, 0}, 1, {1, 0, 0}}), 0);
  EXPECT_EQ(pulled(inside({12, 0, 0}, 1)), 0);
  EXPECT_EQ(pulled(outside({10, 0, 0}, 1)), 0);
}

TEST(EvidenceField, RemovingTheLastMarkRestoresThePreviousField) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 30);
  const std::vector<Mark> first{inside({0, 0, 0}, 8)};
  std::vector<Mark> second = first;
  second.push_back(outside({7, 0, 0}, 4));
  EvidenceField field(scene.image);
  field.update(first);
  const Mask before = field.object();
  field.update(second);
  EXPECT_LT(dice(before, field.object()), 0.98);
  field.update(first);
  EXPECT_GT(dice(before, field.object()), 0.99);
}

TEST(EvidenceField, RepeatedMarksDoNotChangeTheField) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 30);
  std::vector<Mark> marks{inside({0, 0, 0}, 8)};
  EvidenceField field(scene.image);
  field.update(marks);
  marks.push_back(outside({12, 0, 0}, 2));
  field.update(marks);
  const std::vector<float> once(field.probability().begin(), field.probability().end());
  for (int again = 0; again < 3; ++again) field.update(marks);
  ASSERT_EQ(field.probability().size(), once.size());
  for (std::size_t v = 0; v < once.size(); ++v) ASSERT_NEAR(field.probability()[v], once[v], 0.03) << v;
}

}  // namespace
}  // namespace simplexseg
