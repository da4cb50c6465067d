// SPDX-License-Identifier: Apache-2.0
// Contours of RT structure sets on grids that are finer, coarser or shifted, and numbers of regions.
#include "structure_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "image/mask.h"
#include "io/dicom/plane_positions.h"
#include "io/dicom/rtstruct_grid.h"
#include "io/dicom/rtstruct_raster.h"
#include "io/labels/labels_io.h"
#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::data_folder;
using test::error_of;

/// Region of squares with half side `half` around (0, 0) at the positions `z`.
StructureRegion squares(const std::vector<double>& z, double half = 8, double scale = 1) {
  StructureRegion region;
  region.name = {1, "squares"};
  for (const double at : z) {
    std::vector<double>& contour = region.contours.emplace_back();
    for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
      for (const double part : {x * half * scale, y * half * scale, at * scale}) contour.push_back(part);
  }
  return region;
}

std::vector<double> from_to(double first, double last, double step) {
  std::vector<double> positions;
  for (int n = 0; first + n * step <= last + 1e-9; ++n) positions.push_back(first + n * step);
  return positions;
}

/// Grid whose voxels are squares of 1 mm around the z axis, with slices from `first` to `last`; all lengths multiplied
/// by `scale`. A square of half side 8 contains 256 voxel centres of a slice.
VolumeGeometry grid_of(double first, double last, double step, double scale = 1) {
  VolumeGeometry grid;
  grid.size = {24, 24, static_cast<int>(std::lround((last - first) / step)) + 1};
  grid.spacing_mm = Eigen::Vector3d(1, 1, step) * scale;
  grid.origin_mm = Eigen::Vector3d(-11.5, -11.5, first) * scale;
  return grid;
}

/// Returns the positions of the labelled slices, in slices from the first; requires that each has `voxels` voxels.
std::vector<int> slices_in(const Volume& labels, int voxels = 256) {
  std::vector<int> slices;
  for (int k = 0; k < labels.geometry().size[2]; ++k) {
    int count = 0;
    for (int j = 0; j < labels.geometry().size[1]; ++j)
      for (int i = 0; i < labels.geometry().size[0]; ++i) count += labels.value(i, j, k) != 0;
    if (count == 0) continue;
    EXPECT_EQ(count, voxels) << "slice " << k;
    slices.push_back(k);
  }
  return slices;
}

StructureLabels rasterise(const StructureRegion& region, const VolumeGeometry& grid) {
  return rasterise_regions({&region, 1}, grid, "rt.dcm");
}

TEST(StructureSet, ContoursFinerThanTheSlicesKeepTheVolume) {
  for (const double scale : {1.0, 0.003, 40.0}) {  // micro-CT, and grids of 100 mm
    const StructureLabels read = rasterise(squares(from_to(-10, 10, 1), 8, scale), grid_of(-15, 12.5, 2.5, scale));
    EXPECT_EQ(slices_in(read.labels), (std::vector<int>{2, 3, 4, 5, 6, 7, 8, 9, 10})) << scale;
    ASSERT_EQ(read.warnings.size(), 1u);
    EXPECT_HAS(read.warnings[0], "lie between slices of the image");
  }
}

TEST(StructureSet, ContoursCoarserThanTheSlicesFillTheirSlabs) {
  for (const double scale : {1.0, 0.003, 40.0}) {
    const StructureLabels read = rasterise(squares(from_to(-6, 6, 3), 8, scale), grid_of(-10, 10, 1, scale));
    EXPECT_EQ(slices_in(read.labels), (std::vector<int>{3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17}));
    EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
  }
  const StructureLabels gap = rasterise(squares({-6, -3, 3, 6}), grid_of(-10, 10, 1));
  EXPECT_EQ(slices_in(gap.labels), (std::vector<int>{3, 4, 5, 6, 7, 8, 12, 13, 14, 15, 16, 17}));
  ASSERT_EQ(gap.warnings.size(), 1u);
  EXPECT_HAS(gap.warnings[0], "3 slices between the first and the last have no contour");
}

TEST(StructureSet, ContoursHalfWayBetweenSlicesKeepTheirNumber) {
  EXPECT_EQ(slices_in(rasterise(squares(from_to(-2.5, 2.5, 1)), grid_of(-10, 10, 1)).labels).size(), 6u);
  EXPECT_EQ(slices_in(rasterise(squares(from_to(-2.7, 2.3, 1)), grid_of(-10, 10, 1)).labels).size(), 6u);
  EXPECT_EQ(slices_in(rasterise(squares({2.3}), grid_of(-10, 10, 1)).labels), (std::vector<int>{12}));
}

TEST(StructureSet, RegionsBetweenSlicesAreDrawnOnTheNearest) {
  EXPECT_EQ(slices_in(rasterise(squares({1.0, 1.3, 1.6}), grid_of(-10, 10, 5)).labels), (std::vector<int>{2}));
}

TEST(StructureSet, AContourOfOnePlaneHasTheThicknessThatIsStated) {
  StructureRegion region = squares({0});
  EXPECT_EQ(slices_in(rasterise(region, grid_of(-10, 10, 1)).labels), (std::vector<int>{10}));
  region.slab_mm = 3;
  EXPECT_EQ(slices_in(rasterise(region, grid_of(-10, 10, 1)).labels), (std::vector<int>{9, 10, 11}));
  EXPECT_NEAR(grid_of_regions({&region, 1}, {&region, 1}, "rt.dcm").spacing_mm[2], 3, 1e-9);
}

TEST(StructureSet, EqualContoursCountOnceAndOthersAreHoles) {
  StructureRegion region = squares({0, 1, 2});
  const StructureRegion inner = squares({0, 1, 2}, 4);
  region.contours.insert(region.contours.end(), inner.contours.begin(), inner.contours.end());
  EXPECT_EQ(slices_in(rasterise(region, grid_of(-10, 10, 1)).labels, 256 - 64).size(), 3u);
  // Twice: as it is, in the opposite order from another corner, and closed by its first point.
  region.contours.push_back(region.contours[0]);
  std::vector<double> opposite, closed = region.contours[2];
  for (const std::size_t corner : std::array<std::size_t, 4>{2, 1, 0, 3})
    for (std::size_t axis = 0; axis < 3; ++axis) opposite.push_back(region.contours[1][3 * corner + axis]);
  closed.insert(closed.end(), {closed[0], closed[1], closed[2]});
  region.contours.push_back(opposite);
  region.contours.push_back(closed);
  const StructureLabels read = rasterise(region, grid_of(-10, 10, 1));
  EXPECT_EQ(slices_in(read.labels, 256 - 64).size(), 3u);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_HAS(read.warnings[0], "3 contours occur twice");
}

TEST(StructureSet, PlanesAreFoundOnAnyScale) {
  for (const double scale : {0.008, 1.0, 100.0}) {
    std::vector<double> positions;
    for (int n = 0; n < 10; ++n)
      for (const int group : {0, 250})  // a part of 240 planes without contours
        for (const double noise : {0.0, 0.002}) positions.push_back((n + group + noise) * scale);
    for (const double limit : {0.2, 10.0}) {
      const double tolerance = plane_tolerance(positions, 0, limit * scale);
      EXPECT_EQ(planes_of(positions, tolerance).planes.size(), 20u) << scale << ", " << tolerance;
      EXPECT_NEAR(planes_of(positions, tolerance).distance(), scale, 0.01 * scale);
    }
  }
  const StructureRegion micro = squares(from_to(-8, 8, 1), 8, 0.008);
  EXPECT_NEAR(grid_of_regions({&micro, 1}, {&micro, 1}, "rt.dcm").spacing_mm[2], 0.008, 1e-6);
}

class StructureSetFiles : public test::FolderTest {
 protected:
  std::filesystem::path write_set(const std::vector<test::Squares>& regions) {
    return write("rt.dcm", test::structure_set_of_squares(Eigen::Isometry3d::Identity(), regions));
  }
};

TEST_F(StructureSetFiles, ContoursCombinedByXorAreClosed) {
  const auto path = write_set({{"ring", 8, {0, 1, 2}, 0, "CLOSEDPLANAR_XOR"}});
  EXPECT_EQ(read_structure_regions(path).at(0).contours.size(), 3u);
  EXPECT_EQ(slices_in(read_structure_set(path, grid_of(-10, 10, 1)).labels).size(), 3u);
}

TEST_F(StructureSetFiles, NumbersThatAreNoLabelsAreReplaced) {
  const auto path =
      write_set({{"body", 8, {0, 1, 2}, test::kNumberZero}, {"organ", 4, {0, 1}, 1}, {"far", 4, {2}, 70000}});
  const std::vector<StructureRegion> regions = read_structure_regions(path);
  ASSERT_EQ(regions.size(), 3u);
  EXPECT_EQ(regions[0].name.value, 2);
  EXPECT_EQ(regions[1].name.value, 1);
  EXPECT_EQ(regions[2].name.value, 3);
  LabelFile file(path);
  const LoadedLabels organ = file.read({.label = 1});
  EXPECT_TRUE(organ.warnings.empty()) << organ.warnings[0];
  const LoadedLabels body = file.read({.name = "body"});
  ASSERT_EQ(body.warnings.size(), 1u);
  EXPECT_HAS(body.warnings[0], "'body' has the number 0, which cannot be a label: it becomes label 2");
  std::vector<std::string> warnings;
  const Volume onto = file.read_onto(grid_of(-10, 10, 1), "the image", warnings, {.label = 1});
  EXPECT_EQ(slices_in(onto, 64).size(), 2u);
}

TEST_F(StructureSetFiles, OverlappingRegionsAreReadAlone) {
  const auto path = write_set({{"body", 8, {0, 1, 2}}, {"organ", 4, {0, 1, 2}}});
  LabelFile file(path);
  EXPECT_TRUE(file.reads_alone());
  std::vector<std::string> warnings;
  const Volume organ = file.read_onto(grid_of(-10, 10, 1), "the image", warnings, {.name = "organ"});
  EXPECT_EQ(slices_in(organ, 64).size(), 3u);
  EXPECT_TRUE(warnings.empty());
  file.read_onto(grid_of(-10, 10, 1), "the image", warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_HAS(warnings[0], "192 voxels belong to several regions");
}

TEST(StructureSetReports, FineContoursZeroAndMicrometres) {
  const std::filesystem::path folder = data_folder() / "reports";
  REQUIRE_DATA(folder);
  const auto volume_mm3 = [](const Mask& mask) {
    return static_cast<double>(std::count(mask.voxels.begin(), mask.voxels.end(), 1)) * mask.geometry.spacing_mm.prod();
  };
  std::vector<std::string> warnings;
  const Volume thick = read_volume(folder / "ref_thick.nii.gz");
  EXPECT_NEAR(volume_mm3(mask_of(load_labels_onto(folder / "rt_fine.dcm", thick.geometry(), "the image", warnings), 1)),
              9 * 194 * 2.5, 1e-6)
      << "9 slices of the polygon's 194 voxels; the disc of 8 mm has 197";
  const Volume fine = read_volume(folder / "ref_fine.nii.gz");
  const Mask organ =
      mask_of(load_labels_onto(folder / "rt_zero2.dcm", fine.geometry(), "the image", warnings, {.label = 1}), 1);
  EXPECT_NEAR(volume_mm3(organ), 21 * 110, 1e-6) << "21 slices of the polygon's 110 voxels; the disc of 6 mm has 113";
  const LoadedLabels bead = load_labels(folder / "rt_micro.dcm");
  EXPECT_NEAR(bead.volume.geometry().spacing_mm[2], 0.008, 1e-6);
}

}  // namespace
}  // namespace simplexseg
