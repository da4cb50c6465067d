// SPDX-License-Identifier: Apache-2.0
// Range of intensities as a constraint of the evidence field.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "ellipsoid_scene.h"
#include "field/evidence_field.h"
#include "field/range_effect.h"

namespace simplexseg {
namespace {

TEST(IntensityRange, KeepsOutBrighterTissue) {
  // A ball of which one part is a little brighter.
  const Scene scene = scene_of(
      ellipsoid(48, 1, {1, 1, 1}).truth.geometry,
      [](const Eigen::Vector3d& mm) { return mm.norm() > 14 ? 0.0
                                             : mm.x() > 5   ? 112.0
                                                            : 100.0; }, 3);
  const Eigen::Affine3d world = scene.truth.geometry.world_from_index();
  // Voxels of an object, and those of them in the brighter part and more than a voxel from the other one.
  const auto counts_of = [&](const Mask& mask) {
    std::array<int, 2> counts{};
    for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
      const auto n = static_cast<int>(v);
      const Eigen::Vector3d mm = world * Eigen::Vector3d(n % 48, n / 48 % 48, n / 48 / 48);
      if (mask.voxels[v]) ++counts[0], counts[1] += mm.x() > 6.5 && mm.norm() < 12.5;
    }
    return counts;
  };
  const std::vector<Mark> marks{inside({-3, 0, 0}, 6)};
  EvidenceSettings settings;
  EvidenceField free(scene.image);
  free.update(marks);
  settings.intensity_range = {60, 106};
  EvidenceField limited(scene.image, run_serially(), settings);
  limited.update(marks);
  const auto [in_free, bright_in_free] = counts_of(free.object());
  const auto [in_limited, bright_in_limited] = counts_of(limited.object());
  EXPECT_GT(bright_in_free, 500) << "without a range the brighter part is included";
  EXPECT_LT(bright_in_limited, 10) << "single voxels of noise";
  EXPECT_GT(in_limited, 0.6 * in_free);
}

TEST(IntensityRange, FillsEnclosedSpotsAndYieldsToMarks) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 4);
  Volume image = scene.image;
  const Eigen::Affine3d index = image.geometry().index_from_world();
  const auto set = [&](const Eigen::Vector3d& mm, float value) {
    const Eigen::Vector3i at = (index * mm).array().round().cast<int>();
    const std::size_t voxel = image.offset(at[0], at[1], at[2]);
    image.voxels<float>()[voxel] = value;
    return voxel;
  };
  const std::size_t spot = set({8, 0, 0}, 900), outer = set({0, 13, 0}, 900);
  EvidenceSettings settings;
  settings.intensity_range = {120, 180};
  settings.image_smoothing = 0;
  EvidenceField field(image, run_serially(), settings);
  field.update(std::vector{inside({0, 0, 0}, 6)});
  EXPECT_EQ(field.object().voxels[spot], 1) << "a spot within the object is filled";
  EXPECT_EQ(field.object().voxels[outer], 0);
  field.update(std::vector{inside({0, 0, 0}, 6), inside({0, 13, 0}, 4)});
  EXPECT_EQ(field.object().voxels[outer], 1) << "a mark is stronger than the range";
}

TEST(RangeEffects, AreFoundForAllVoxelsNoneAndTheSeed) {
  const Scene scene = ellipsoid(48, 1, {14, 10, 10}, 4);
  const auto effect = [&](const IntensityRange& range, const Mark& seed, const Volume& image) {
    return effect_of(range, image, kVoxelCells, seed, EvidenceSettings().image_smoothing, run_serially());
  };
  const Mark in_object = inside({0, 0, 0}, 6), beside = inside({0, 20, 0}, 3);
  EXPECT_EQ(effect({}, in_object, scene.image), RangeEffect::Limits);
  EXPECT_EQ(effect({120, 180}, in_object, scene.image), RangeEffect::Limits);
  EXPECT_EQ(effect({147, 153}, in_object, scene.image), RangeEffect::Limits) << "noise is smoothed";
  EXPECT_EQ(effect({20, 80}, in_object, scene.image), RangeEffect::WithoutSeed);
  EXPECT_EQ(effect({20, 80}, beside, scene.image), RangeEffect::Limits);
  EXPECT_EQ(effect({20, 80}, inside({0.5, 0.5, 0.5}, 0.01), scene.image), RangeEffect::WithoutSeed);
  EXPECT_EQ(effect({120, 180}, inside({9, 0, 0}, 6), scene.image), RangeEffect::Limits) << "a part is outside";
  EXPECT_EQ(effect({120, 180}, inside({23, 23, 23}, 400), scene.image), RangeEffect::WithoutSeed);
  EXPECT_EQ(effect({-1000, 1000}, in_object, scene.image), RangeEffect::AllVoxels);
  EXPECT_EQ(effect({2000, 3000}, in_object, scene.image), RangeEffect::NoVoxel);
  Volume damaged = scene.image;
  damaged.voxels<float>()[7] = NAN;
  EXPECT_EQ(effect({-1000, 1000}, in_object, damaged), RangeEffect::AllVoxels);
  for (const RangeEffect one :
       {RangeEffect::Limits, RangeEffect::AllVoxels, RangeEffect::NoVoxel, RangeEffect::WithoutSeed})
    EXPECT_EQ(range_effect_of(name_of(one)), one);
}

}  // namespace
}  // namespace simplexseg
