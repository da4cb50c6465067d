// SPDX-License-Identifier: Apache-2.0
#include "field/evidence_field.h"
#include "field/field_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/error.h"
#include "ellipsoid_scene.h"
#include "image/metrics.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

double dice_of(const Scene& scene, std::span<const Mark> marks, const EvidenceSettings& settings = {}) {
  EvidenceField field(scene.image, run_serially(), settings);
  field.update(marks);
  return dice(scene.truth, field.object());
}

float at(const EvidenceField& field, const Volume& volume, const Eigen::Vector3d& mm) {
  const Eigen::Vector3d index = volume.geometry().index_from_world() * mm;
  const VoxelBox& box = field.box();
  return field.probability()[box.offset(static_cast<int>(std::lround(index[0])) - box.first[0],
                                        static_cast<int>(std::lround(index[1])) - box.first[1],
                                        static_cast<int>(std::lround(index[2])) - box.first[2])];
}

TEST(EvidenceField, FindsAnEllipsoidFromASeedOfAnySize) {
  const Scene scene = ellipsoid(48, 1, {16, 11, 9});
  for (const double radius : {7.0, 9.0})
    EXPECT_GT(dice_of(scene, std::vector{inside({0, 0, 0}, radius)}), 0.93) << radius;
}

TEST(EvidenceField, FindsAnEllipsoidInNoiseOfAQuarterOfTheContrast) {
  const Scene scene = ellipsoid(48, 1, {16, 11, 9}, 25);
  EXPECT_GT(dice_of(scene, std::vector{inside({0, 0, 0}, 9)}), 0.95);
}

TEST(EvidenceField, ThickSlicesGiveTheSameSurface) {
  const Scene fine = ellipsoid(64, 1, {18, 14, 16}), thick = ellipsoid(64, 4, {18, 14, 16});
  const std::vector marks{inside({0, 0, 0}, 10)};
  EvidenceField a(fine.image), b(thick.image);
  a.update(marks);
  b.update(marks);
  EXPECT_GT(dice(thick.truth, b.object()), 0.95);
  const Agreement of_a = compare(fine.truth, a.object()), of_b = compare(thick.truth, b.object());
  EXPECT_NEAR(of_a.test_mm3, of_b.test_mm3, 0.06 * of_a.test_mm3);
}

TEST(EvidenceField, StaysWithinZeroAndOneAndObeysEveryMark) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 10);
  // Both balls contradict the image.
  const std::vector marks{inside({0, 0, 0}, 6), inside({0, 14, 0}, 2), outside({10, 0, 0}, 2)};
  EvidenceField field(scene.image);
  field.update(marks);
  for (const float p : field.probability()) ASSERT_TRUE(p >= 0 && p <= 1);
  EXPECT_EQ(at(field, scene.image, {0.5, 14.5, 0.5}), 1);
  EXPECT_EQ(at(field, scene.image, {9.5, 0.5, 0.5}), 0);
  EXPECT_EQ(at(field, scene.image, {0.5, 0.5, 0.5}), 1);
}

TEST(EvidenceField, EveryKindOfMarkChangesTheField) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 10);
  EvidenceField plain(scene.image);
  plain.update(std::vector{inside({0, 0, 0}, 6)});
  const auto with = [&](const Mark& mark, const Eigen::Vector3d& place) {
    EvidenceField field(scene.image);
    field.update(std::vector{inside({0, 0, 0}, 6), mark});
    return at(field, scene.image, place) - at(plain, scene.image, place);
  };
  EXPECT_GT(with(inside({0.5, 15.5, 0.5}, 2), {0.5, 15.5, 0.5}), 0.5);
  EXPECT_LT(with(outside({11.5, 0.5, 0.5}, 2), {11.5, 0.5, 0.5}), -0.5);
  // A surface 4 mm inside the bright part: voxels beyond it become background, voxels before it stay foreground.
  const Mark boundary{MarkKind::Boundary, {9.5, 0.5, 0.5}, 1, {2, 0, 0}};
  EXPECT_LT(with(boundary, {11.5, 0.5, 0.5}), -0.5);
  EXPECT_GT(with(boundary, {7.5, 0.5, 0.5}), -0.1);
  // With the opposite direction the other side is background.
  const Mark turned{MarkKind::Boundary, {9.5, 0.5, 0.5}, 1, {-2, 0, 0}};
  EXPECT_LT(with(turned, {8.5, 0.5, 0.5}), -0.5);
}

TEST(EvidenceField, ABoundaryMarkCorrectsTheWrongSideLikeAMarkThere) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 20);
  const Mark seed = inside({0, 0, 0}, 6);
  const auto after = [&](const Mark& mark) {
    auto field = std::make_unique<EvidenceField>(scene.image);
    field->update(std::vector{seed});
    field->update(std::vector{seed, mark});
    return field;
  };
  EvidenceField before(scene.image);
  before.update(std::vector{seed});
  // The surface is to move inwards by 4 mm. The outside mark lies in the middle of the wrong part.
  const auto boundary = after({MarkKind::Boundary, {9.5, 0.5, 0.5}, 1.8, {1, 0, 0}});
  const auto plain = after(outside({11.7, 0.5, 0.5}, 1.8));
  EXPECT_LT(at(*boundary, scene.image, {11.5, 0.5, 0.5}), 0.1);
  EXPECT_GT(at(before, scene.image, {11.5, 0.5, 0.5}), 0.8);
  float most = 0;
  for (int y = -12; y <= 12; ++y)
    for (int x = -16; x <= 16; ++x) {
      const Eigen::Vector3d place(x + 0.5, y + 0.5, 0.5);
      if ((place - Eigen::Vector3d(9.5, 0.5, 0.5)).norm() < 6) continue;
      most = std::max(most, std::abs(at(*boundary, scene.image, place) - at(*plain, scene.image, place)));
    }
  EXPECT_LT(most, 0.1) << "elsewhere it changes nothing";
}

TEST(EvidenceField, OtherObjectsAreBackground) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10});
  const std::vector others{inside({13, 0, 0}, 5)};
  EvidenceField field(scene.image), alone(scene.image);
  field.update(std::vector{inside({0, 0, 0}, 6)}, others);
  alone.update(std::vector{inside({0, 0, 0}, 6)});
  const Mask object = field.object(), all = alone.object();
  const Eigen::Affine3d world = scene.truth.geometry.world_from_index();
  int shared = 0, excluded = 0;
  for (int k = 0; k < 48; ++k) {
    for (int j = 0; j < 48; ++j) {
      for (int i = 0; i < 48; ++i) {
        if ((world * Eigen::Vector3d(i, j, k) - others[0].position_mm).norm() > 5) continue;
        const std::size_t v = scene.image.offset(i, j, k);
        shared += object.voxels[v], excluded += all.voxels[v];
      }
    }
  }
  EXPECT_EQ(shared, 0);
  EXPECT_GT(excluded, 100);
  EXPECT_GT(std::count(object.voxels.begin(), object.voxels.end(), 1), 3000);
}

TEST(EvidenceField, MarksOfOtherObjectsDoNotChangeThePrior) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 10);
  EvidenceField field(scene.image), alone(scene.image);
  field.record_features(true);
  alone.record_features(true);
  const std::vector seed{inside({0, 0, 0}, 6)};
  field.update(seed, std::vector{inside({0, 17, 0}, 3)});
  alone.update(seed);
  EXPECT_EQ(field.box(), alone.box());
  EXPECT_EQ(field.features().marks.size(), 21u);
  EXPECT_EQ(field.features().marks, alone.features().marks);
}

TEST(EvidenceField, EverySettingChangesTheField) {
  const Scene scene = ellipsoid(56, 1, {12, 8, 8}, 1.5);
  const std::vector marks{inside({-4, 0, 0}, 5), outside({16, 3, 0}, 2)};
  const auto field_with = [&](const EvidenceSettings& settings) {
    EvidenceField field(scene.image, run_serially(), settings);
    field.update(marks);
    return std::vector<float>(field.probability().begin(), field.probability().end());
  };
  const std::vector<float> plain = field_with({});
  const EvidenceSettings usual;
  double EvidenceSettings::*const all[]{&EvidenceSettings::image_smoothing,     &EvidenceSettings::sharpness,
                                        &EvidenceSettings::prior_weight,        &EvidenceSettings::length_cost,
                                        &EvidenceSettings::outside_marks_share, &EvidenceSettings::field_smoothing,
                                        &EvidenceSettings::margin_share,        &EvidenceSettings::band_half_width,
                                        &EvidenceSettings::band_window,         &EvidenceSettings::fairing_scale};
  for (double EvidenceSettings::*const setting : all) {
    EvidenceSettings settings;
    settings.*setting = usual.*setting * 0.6;
    EXPECT_NE(field_with(settings), plain) << "the setting with the value " << usual.*setting;
  }
  EvidenceSettings fixed;
  fixed.sharpness = 0;
  const std::vector<float> of_fixed = field_with(fixed);
  fixed.beta = 300;
  EXPECT_NE(field_with(fixed), of_fixed);
  EvidenceSettings bounded;
  bounded.least_beta = 600;
  bounded.largest_beta = 700;
  EXPECT_NE(field_with(bounded), plain);
  bounded = {};
  bounded.least_beta = 7000;
  EXPECT_NE(field_with(bounded), plain);
  for (bool EvidenceSettings::*const voice :
       {&EvidenceSettings::use_appearance, &EvidenceSettings::use_geodesic, &EvidenceSettings::use_random_walk}) {
    EvidenceSettings deaf;
    deaf.*voice = false;
    EXPECT_NE(field_with(deaf), plain);
  }
  EvidenceSettings plain_cut;
  plain_cut.expected_dice_threshold = false;
  EXPECT_NE(field_with(plain_cut), plain);
  EvidenceSettings closed;
  closed.open_side = -2;
  EXPECT_NE(field_with(closed), plain);
  EvidenceSettings rough;
  rough.tolerance = 0.3;
  EXPECT_NE(field_with(rough), plain);
  rough = {};
  rough.most_iterations = 1;
  EXPECT_NE(field_with(rough), plain);
  EvidenceSettings wide;
  wide.least_margin = 30;
  EXPECT_NE(field_with(wide), plain);
}

/// Cells of a block of the prior along each axis.
std::array<int, 3> width_of_blocks(const EvidenceField& field) {
  std::array<int, 3> width;
  for (int a = 0; a < 3; ++a)
    width[a] = (field.box().size[a] + field.features().size[a] - 1) / field.features().size[a];
  return width;
}

TEST(EvidenceField, ThePriorOfALargeObjectUsesBlocks) {
  const Scene scene = ellipsoid(64, 1, {20, 18, 18}, 40);
  const std::vector marks{inside({0, 0, 0}, 15)};
  EvidenceSettings fine;
  fine.blocks_per_scale = 100;
  EvidenceField blocks(scene.image), voxels(scene.image, run_serially(), fine);
  blocks.record_features(true);
  voxels.record_features(true);
  blocks.update(marks);
  voxels.update(marks);
  EXPECT_EQ(width_of_blocks(blocks), (std::array{2, 2, 2}));
  EXPECT_EQ(width_of_blocks(voxels), (std::array{1, 1, 1}));
  EXPECT_GT(dice(scene.truth, blocks.object()), 0.97);
  EXPECT_GT(dice(blocks.object(), voxels.object()), 0.97);
  EXPECT_LT(blocks.bytes(), 0.8 * static_cast<double>(voxels.bytes()));
}

TEST(EvidenceField, BlocksAreNarrowAlongThickSlices) {
  const Scene scene = ellipsoid(64, 4, {30, 30, 30});
  EvidenceField field(scene.image);
  field.record_features(true);
  field.update(std::vector{inside({0, 0, 0}, 24)});
  EXPECT_EQ(width_of_blocks(field), (std::array{3, 3, 1}));
}

TEST(EvidenceField, ThePriorStopsALeakThroughANeck) {
  // Two balls of the same brightness, 28 mm apart, and a neck of 1.3 mm radius between them.
  Scene scene = ellipsoid(56, 1, {1, 1, 1}, 25);
  const Eigen::Affine3d world = scene.image.geometry().world_from_index();
  for (int k = 0; k < 56; ++k) {
    for (int j = 0; j < 56; ++j) {
      for (int i = 0; i < 56; ++i) {
        const Eigen::Vector3d p = world * Eigen::Vector3d(i, j, k);
        const Eigen::Vector3d to_second(p.x() - 14, p.y(), p.z()), to_first(p.x() + 14, p.y(), p.z());
        const bool neck = std::fabs(p.x()) < 14 && std::hypot(p.y(), p.z()) < 1.3;
        const std::size_t v = scene.image.offset(i, j, k);
        scene.truth.voxels[v] = to_first.norm() < 7;
        const bool bright = to_first.norm() < 7 || to_second.norm() < 7 || neck;
        if (bright) scene.image.voxels<float>()[v] += 100;
      }
    }
  }
  const std::vector marks{inside({-14, 0, 0}, 6)};
  EvidenceSettings loose;
  loose.prior_weight = 0;
  EXPECT_GT(dice_of(scene, marks), 0.92);
  EXPECT_LT(dice_of(scene, marks, loose), dice_of(scene, marks) - 0.02);
}

TEST(EvidenceField, TheBoxGrowsOnlyWithTheObject) {
  const Scene scene = ellipsoid(64, 1, {16, 16, 16});
  EvidenceField field(scene.image);
  field.update(std::vector{inside({0, 0, 0}, 8)});
  EXPECT_GT(dice(scene.truth, field.object()), 0.95);
  EXPECT_GT(field.report().growths, 0);
  const VoxelBox& box = field.box();
  for (int a = 0; a < 3; ++a) {
    EXPECT_LE(box.first[a], 10);
    EXPECT_GE(box.first[a] + box.size[a], 54);
  }
  EXPECT_LT(box.voxel_count(), scene.image.geometry().voxel_count() * 7 / 10);
  EXPECT_FALSE(field.report().leaks);
}

TEST(EvidenceField, ReportsALeak) {
  Scene scene = ellipsoid(40, 1, {12, 12, 12});
  for (float& voxel : scene.image.voxels<float>()) voxel = 50;  // without a border
  EvidenceField field(scene.image);
  field.update(std::vector{inside({0, 0, 0}, 16)});
  EXPECT_TRUE(field.report().leaks);
  EvidenceField held(ellipsoid(40, 1, {12, 12, 12}).image);
  held.update(std::vector{inside({0, 0, 0}, 8)});
  EXPECT_FALSE(held.report().leaks);
}

TEST(EvidenceField, ThickSlicesAreNoLeak) {
  const Scene scene = ellipsoid(96, 8, {20, 20, 20});  // 12 slices of 8 mm
  EvidenceField field(scene.image);
  field.update(std::vector{inside({0, 0, 0}, 12)});
  EXPECT_GT(dice(scene.truth, field.object()), 0.9);
  EXPECT_FALSE(field.report().leaks);
}

TEST(EvidenceField, AnObjectCutByTheVolumeIsNoLeak) {
  const Scene scene = ellipsoid(40, 1, {10, 10, 60});  // cut by the first and the last slice
  EvidenceField field(scene.image);
  field.update(std::vector{inside({0, 0, 0}, 6)});
  EXPECT_GT(dice(scene.truth, field.object()), 0.8);
  EXPECT_FALSE(field.report().leaks);
}

TEST(EvidenceField, ReportsTheExpectedDice) {
  const Scene sharp = ellipsoid(40, 1, {12, 12, 12});
  EvidenceField field(sharp.image);
  field.update(std::vector{inside({0, 0, 0}, 8)});
  EXPECT_GT(dice(sharp.truth, field.object()), 0.95);
  EXPECT_GT(field.report().expected_dice, 0.92);
  EXPECT_LE(field.report().expected_dice, 1);

  Scene noise = ellipsoid(40, 1, {12, 12, 12});
  std::uint64_t state = 1;
  for (float& voxel : noise.image.voxels<float>()) {  // there is no object
    state = state * 6364136223846793005u + 1442695040888963407u;
    voxel = static_cast<float>(state >> 40);
  }
  EvidenceField unsure(noise.image);
  unsure.update(std::vector{inside({0, 0, 0}, 4)});
  EXPECT_LT(unsure.report().expected_dice, 0.8);
}

TEST(EvidenceField, VoxelsThatAreNotFiniteConductNothingAndStayOutside) {
  Scene scene = ellipsoid(48, 1, {16, 10, 10});
  const std::vector marks{inside({-5, 0, 0}, 6)};
  // A wall of NaN across the object; the part behind it is not reached.
  for (int k = 0; k < 48; ++k)
    for (int j = 0; j < 48; ++j)
      scene.image.voxels<float>()[scene.image.offset(30, j, k)] =
          (j + k) % 2 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
  EvidenceField field(scene.image);
  field.update(marks);
  for (const float p : field.probability()) ASSERT_TRUE(p >= 0 && p <= 1);
  const Mask object = field.object();
  std::size_t before = 0, behind = 0;
  for (int k = 0; k < 48; ++k)
    for (int j = 0; j < 48; ++j)
      for (int i = 0; i < 48; ++i) (i < 30 ? before : behind) += object.voxels[scene.image.offset(i, j, k)];
  EXPECT_EQ(behind, 0u);
  EXPECT_GT(before, 3000u);
}

TEST(EvidenceField, TheMarkOfAClickEndsAtTheSurface) {
  const Scene scene = ellipsoid(80, 1, {20, 20, 20});
  EvidenceSettings settings;
  settings.margin_share = 1;
  EvidenceField field(scene.image, run_serially(), settings);
  field.update(std::vector{inside({0, 0, 0}, 14)});
  EXPECT_NEAR(field.brush_mm(MarkKind::Inside, {0, 0, 22}), settings.brush, 1e-9);
  EXPECT_NEAR(field.brush_mm(MarkKind::Inside, {0.5, 0.5, 20.5}), settings.smallest_brush, 1e-9);
  EXPECT_NEAR(field.brush_mm(MarkKind::Boundary, {0, 0, 20.5}), settings.brush, 1e-9);
  EXPECT_NEAR(field.brush_mm(MarkKind::Outside, {0, 0, 18}), settings.brush, 1e-9);
  EXPECT_NEAR(field.brush_mm(MarkKind::Outside, {0.5, 0.5, 19.5}), settings.smallest_brush, 1e-9);
}

TEST(EvidenceField, ReportsAnIncreasingFraction) {
  const Scene scene = ellipsoid(64, 1, {16, 16, 16}, 10);
  EvidenceField field(scene.image), silent(scene.image);
  std::vector marks{inside({0, 0, 0}, 8)};
  for (int update = 0; update < 2; ++update) {
    std::vector<float> fractions{0};
    field.update(marks, {}, [&](float fraction) {
      EXPECT_GT(fraction, fractions.back());
      fractions.push_back(fraction);
    });
    if (update == 0) {
      EXPECT_GT(field.report().growths, 0);
    }
    EXPECT_GT(fractions.size(), 5u);  // constraints, prior, features, walker, surface
    EXPECT_GT(fractions.back(), 0.9f);
    EXPECT_LT(fractions.back(), 1.0f);
    silent.update(marks);
    EXPECT_TRUE(std::ranges::equal(field.probability(), silent.probability())) << "a report changes no bit";
    marks.push_back(outside({19, 0, 0}, 2));
  }
}

TEST(EvidenceField, UsesAsMuchMemoryAsExpected) {
  const Scene scene = ellipsoid(96, 1, {28, 28, 28});
  EvidenceField field(scene.image);
  std::size_t solving = 0;
  field.update(std::vector{inside({0, 0, 0}, 20)}, {}, {}, [&] { solving = field.bytes(); });
  const FieldMemory expected = expected_field_memory(field.box().voxel_count());
  const auto cells = static_cast<double>(field.box().voxel_count());
  EXPECT_NEAR(static_cast<double>(field.bytes()) / cells, static_cast<double>(expected.held) / cells, 2);
  EXPECT_NEAR(static_cast<double>(solving) / cells, static_cast<double>(expected.held + expected.solving) / cells, 20);
}

TEST(EvidenceField, RefusesInvalidMarks) {
  const Scene scene = ellipsoid(24, 1, {6, 6, 6});
  EvidenceField field(scene.image);
  EXPECT_THROW(field.update({}), Error);
  EXPECT_THROW(field.update(std::vector{outside({0, 0, 0}, 2)}), Error);
  EXPECT_THROW(field.update(std::vector{inside({0, 0, 0}, 0)}), Error);
  EXPECT_THROW(field.update(std::vector{inside({0, 0, 90}, 2)}), Error);
  EXPECT_THROW(field.update(std::vector{Mark{MarkKind::Boundary, {0, 0, 0}, 1, {0, 0, 0}}}), Error);
  EXPECT_THROW(EvidenceField(Volume{}), Error);
}

}  // namespace
}  // namespace simplexseg
