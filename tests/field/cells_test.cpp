// SPDX-License-Identifier: Apache-2.0
// Fields on cells larger than voxels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "ellipsoid_scene.h"
#include "field/box_image.h"
#include "field/cell_resampling.h"
#include "field/evidence_box.h"
#include "field/evidence_field.h"
#include "image/metrics.h"

namespace simplexseg {
namespace {

Volume ramp(VoxelType type) {
  VolumeGeometry geometry;
  geometry.size = {12, 8, 6};
  Volume volume(geometry, type);
  visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
    for (int v = 0; v < 12 * 8 * 6; ++v) volume.voxels<T>()[v] = static_cast<T>(v % 12);
  });
  return volume;
}

TEST(Cells, HaveTheMeanOfTheirVoxels) {
  const Volume volume = ramp(VoxelType::Int16);
  const BoxImage voxels = extract_box(volume, kVoxelCells, {{0, 0, 0}, {12, 8, 6}}, run_serially());
  const BoxImage cells = extract_box(volume, {2.5, 2, 3}, {{0, 0, 0}, {5, 4, 2}}, run_serially());
  ASSERT_EQ(voxels.value[0], 0);
  ASSERT_EQ(voxels.value[11], 1);
  // Cell 0 holds voxels 0, 1 and half of 2; the last one holds voxels 10 and 11.
  std::vector<float> means;
  for (const double sum : {0 + 1 + 0.5 * 2, 0.5 * 2 + 3 + 4, 5 + 6 + 0.5 * 7, 0.5 * 7 + 8 + 9, 10 + 11.0})
    means.push_back(static_cast<float>(means.size() == 4 ? sum / 2 : sum / 2.5));
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(cells.value[i], (means[i] - means[0]) / (means[4] - means[0]), 1e-5) << i;
  EXPECT_EQ(std::ranges::count(cells.finite, 1), 5 * 4 * 2);
}

TEST(Cells, IgnoreVoxelsThatAreNotFinite) {
  Volume volume = ramp(VoxelType::Float32);
  const auto voxels = volume.voxels<float>();
  const BoxImage without = extract_box(volume, {2, 2, 2}, {{0, 0, 0}, {6, 4, 3}}, run_serially());
  voxels[0] = std::numeric_limits<float>::quiet_NaN();  // one of eight
  for (int i = 4; i < 6; ++i)                           // more than half of a cell
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k)
        if (i + j + k != 4) voxels[(k * 8 + j) * 12 + i] = std::numeric_limits<float>::infinity();
  const BoxImage with = extract_box(volume, {2, 2, 2}, {{0, 0, 0}, {6, 4, 3}}, run_serially());
  EXPECT_EQ(with.finite[0], 1);
  EXPECT_GT(with.value[0], without.value[0]);  // voxels of 0 and 1, one of 0 is missing
  EXPECT_EQ(with.finite[2], 0);
  EXPECT_EQ(with.value[2], 0);
  EXPECT_EQ(std::ranges::count(with.finite, 0), 1);
}

TEST(Cells, AreResampledExactlyToEqualCells) {
  std::vector<std::uint16_t> values(6 * 5 * 4);
  for (std::size_t v = 0; v < values.size(); ++v) values[v] = static_cast<std::uint16_t>(1 + 517 * v);
  const CellSize cell{1.6817928305074292, 1.6817928305074292, 1};
  const VoxelBox from{{10, 20, 30}, {6, 5, 4}}, to{{8, 19, 30}, {9, 7, 5}};
  const CellResampling resampling(cell, from, cell, to);
  for (int v = 0; v < static_cast<int>(to.voxel_count()); ++v) {
    const int i = v % 9 - 2, j = v / 9 % 7 - 1, k = v / 63;
    const bool in = i >= 0 && i < 6 && j >= 0 && j < 5 && k < 4;
    EXPECT_EQ(resampling(v, values.data()), in ? values[(k * 5 + j) * 6 + i] : 0) << v;
  }
}

TEST(Cells, AreResampledWithoutUnknownValues) {
  std::vector<std::uint8_t> values(8 * 8 * 8, 200);
  for (int v = 0; v < 512; ++v)
    if (v % 8 < 4) values[v] = 0;  // unknown
  const CellResampling resampling({1, 1, 1}, {{0, 0, 0}, {8, 8, 8}}, {2, 2, 2}, {{0, 0, 0}, {4, 4, 4}});
  for (int v = 0; v < 64; ++v) EXPECT_EQ(resampling(v, values.data()), v % 4 < 2 ? 0 : 200) << v;
}

TEST(Cells, DependOnTheScaleOfTheObjectAndNotOnTheSpacing) {
  EvidenceSettings settings;
  for (const double scale_mm : {18.0, 33.0}) {
    std::vector<double> cells_mm;
    for (const double spacing : {0.35, 0.5, 0.7}) {
      VolumeGeometry volume;
      for (int a = 0; a < 3; ++a) volume.size[a] = static_cast<int>(350 / spacing), volume.spacing_mm[a] = spacing;
      const auto width = static_cast<int>(6 * scale_mm / spacing);
      const VoxelBox box{{10, 20, 30}, {width, width, width}};
      const CellSize cell = cell_size_for(box, volume, scale_mm, settings);
      EXPECT_LE(static_cast<double>(cells_around(box, cell, volume.size).voxel_count()), settings.max_cells);
      cells_mm.push_back(cell[0] * spacing);
      // A block of the prior has a whole number of cells and is as wide as the prior asks for.
      const double parts = scale_mm / settings.blocks_per_scale / cells_mm.back();
      EXPECT_NEAR(parts, std::round(parts) / 0.93, 1e-9);
    }
    EXPECT_NEAR(cells_mm[0], cells_mm[2], 1e-9);
    EXPECT_NEAR(cells_mm[1], cells_mm[2], 1e-9);
  }
}

TEST(Cells, AreVoxelsWhereTheBoxIsSmall) {
  VolumeGeometry volume;
  volume.size = {400, 400, 300};
  volume.spacing_mm = {0.7, 0.7, 2.1};
  EvidenceSettings settings;
  EXPECT_EQ(cell_size_for({{0, 0, 0}, {100, 100, 80}}, volume, 9, settings), kVoxelCells);
  // Thick slices stay: cells are as long as the slices are thick only where they are larger than these.
  const CellSize cell = cell_size_for({{0, 0, 0}, volume.size}, volume, 9, settings);
  EXPECT_NEAR(cell[0], cell[1], 1e-12);
  EXPECT_GT(cell[0], 1.3);
  EXPECT_NEAR(cell[2] * 2.1, std::max(2.1, cell[0] * 0.7), 1e-9);
}

TEST(Cells, FitAWholeVolumeOfAnySize) {
  VolumeGeometry volume;
  volume.size = {20000, 20000, 6000};
  EvidenceSettings settings;
  for (const double scale_mm : {1.0, 50.0, 2000.0}) {
    const CellSize cell = cell_size_for({{0, 0, 0}, volume.size}, volume, scale_mm, settings);
    const double cells = static_cast<double>(cells_around({{0, 0, 0}, volume.size}, cell, volume.size).voxel_count());
    EXPECT_LE(cells, settings.max_cells);
    EXPECT_GT(cells, 0.1 * settings.max_cells);
  }
}

TEST(Cells, GiveTheSegmentationOfTheVoxels) {
  const Scene scene = ellipsoid(80, 1, {25, 20, 18}, 20);
  const std::vector marks{inside({0, 0, 0}, 11), outside({27.5, 0, 0}, 2), inside({0, 0, 16}, 1)};
  EvidenceField voxels(scene.image);
  EvidenceSettings settings;
  settings.max_cells = 6e4;
  EvidenceField cells(scene.image, run_serially(), settings);
  for (std::size_t count = 1; count <= marks.size(); ++count) {
    voxels.update({marks.data(), count});
    cells.update({marks.data(), count});
    EXPECT_EQ(voxels.cell(), kVoxelCells);
    EXPECT_GT(cells.cell()[0], 1.4);
    EXPECT_LE(cells.box().voxel_count(), 60000u);
    EXPECT_GT(dice(scene.truth, cells.object()), dice(scene.truth, voxels.object()) - 0.03) << count;
  }
}

TEST(Cells, GrowWithTheBoxAndKeepThePreviousField) {
  const Scene scene = ellipsoid(80, 1, {24, 20, 20}, 10);
  EvidenceSettings settings;
  settings.max_cells = 6e4;
  EvidenceField field(scene.image, run_serially(), settings);
  std::vector marks{inside({0, 0, 0}, 7)};
  field.update(marks);
  const double before = dice(scene.truth, field.object());
  EXPECT_GT(before, 0.9);
  marks.push_back(outside({25.5, 20, 20}, 2));  // a far mark: the box grows to it
  field.update(marks);
  EXPECT_LE(field.box().voxel_count(), 60000u);
  EXPECT_GT(dice(scene.truth, field.object()), before - 0.02);
}

TEST(Cells, ALargeObjectAtManySidesStopsTheGrowthOfItsBox) {
  const Scene scene = ellipsoid(80, 1, {26, 24, 22}, 10);
  EvidenceSettings settings;
  settings.max_volume = 0.5;  // balls of the scale of this object: it is compact
  EvidenceField limited(scene.image, run_serially(), settings), unlimited(scene.image);
  std::vector marks{inside({0, 0, 0}, 10)};
  limited.update(marks);
  unlimited.update(marks);
  EXPECT_TRUE(limited.report().stopped);
  EXPECT_TRUE(limited.report().leaks);
  EXPECT_FALSE(unlimited.report().stopped);
  EXPECT_FALSE(unlimited.report().leaks);
  EXPECT_GT(unlimited.report().growths, 0);
  EXPECT_LT(2 * limited.box().voxel_count(), unlimited.box().voxel_count());
  EXPECT_GT(limited.object_in_box().count, 10000u) << "what was found is kept";
  // Marks elsewhere enlarge the box.
  const std::size_t before = limited.box().voxel_count();
  marks.push_back(inside({21, 0, 0}, 2));
  limited.update(marks);
  EXPECT_GT(limited.box().voxel_count(), before);
}

TEST(Cells, ASmallSeedFarFromAllEdgesSetsNoLimit) {
  const Scene scene = ellipsoid(72, 1, {26, 26, 26}, 10);
  EvidenceField field(scene.image);
  field.update(std::vector{inside({0, 0, 0}, 3)});
  EXPECT_FALSE(field.report().stopped);
  EXPECT_GT(dice(scene.truth, field.object()), 0.95);
}

}  // namespace
}  // namespace simplexseg
