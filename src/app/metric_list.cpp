// SPDX-License-Identifier: Apache-2.0
#include "app/metric_list.h"

#include <algorithm>
#include <iterator>

#include "core/expect.h"

namespace simplexseg {
namespace {

using C = MaskComparison;

constexpr Metric kMetrics[] = {
    {"dice", "Dice", 4, "2 |A and B| / (|A| + |B|), voxels", [](const C& c) { return c.voxels.dice; }},
    {"hd_mm", "HD mm", 3, "Hausdorff distance between centres of boundary voxels, larger of both directions",
     [](const C& c) { return c.voxels.hd_mm; }},
    {"hd95_mm", "HD95 mm", 3,
     "95th percentile of these distances, each boundary voxel with equal weight, larger of both directions",
     [](const C& c) { return c.voxels.hd95_mm; }},
    {"assd_mm", "ASSD mm", 3, "mean of the mean distances in both directions, each boundary voxel with equal weight",
     [](const C& c) { return c.voxels.assd_mm; }},
    {"hd_directed_mm", "HD to test mm", 3,
     "HD in one direction: from the boundary of the reference to that of the test",
     [](const C& c) { return c.voxels.hd_directed_mm; }},
    {"hd95_directed_mm", "HD95 to test mm", 3,
     "HD95 in one direction: from the boundary of the reference to that of the test",
     [](const C& c) { return c.voxels.hd95_directed_mm; }},
    {"asd_directed_mm", "ASD to test mm", 3,
     "mean distance in one direction: from the boundary of the reference to that of the test",
     [](const C& c) { return c.voxels.asd_directed_mm; }},
    {"reference_mm3", "reference mm3", 1, "number of voxels of the reference times the volume of a voxel",
     [](const C& c) { return c.voxels.reference_mm3; }},
    {"test_mm3", "test mm3", 1, "number of voxels of the test times the volume of a voxel",
     [](const C& c) { return c.voxels.test_mm3; }},
    {"surface_dice", "surface Dice", 4,
     "fraction of the area of both surfaces within the tolerance of the other surface (NSD)",
     [](const C& c) { return c.surfaces.surface_dice; }},
    {"tolerance_mm", "tolerance mm", 3, "tolerance of the surface Dice and of the surface overlaps",
     [](const C& c) { return c.surfaces.tolerance_mm; }},
    {"surface_overlap_reference", "reference near test", 4,
     "fraction of the area of the reference within the tolerance of the test",
     [](const C& c) { return c.surfaces.overlap_reference; }},
    {"surface_overlap_test", "test near reference", 4,
     "fraction of the area of the test within the tolerance of the reference",
     [](const C& c) { return c.surfaces.overlap_test; }},
    {"surface_hd_mm", "surface HD mm", 3, "Hausdorff distance between surface elements, larger of both directions",
     [](const C& c) { return c.surfaces.hd_mm; }},
    {"surface_hd95_mm", "surface HD95 mm", 3,
     "95th percentile of the distances weighted by area, larger of both directions",
     [](const C& c) { return c.surfaces.hd95_mm; }},
    {"surface_assd_mm", "surface ASSD mm", 3, "mean of the mean distances in both directions, weighted by area",
     [](const C& c) { return c.surfaces.assd_mm; }},
    {"surface_asd_reference_mm", "surface ASD to test mm", 3,
     "mean distance of the surface of the reference to that of the test, weighted by area",
     [](const C& c) { return c.surfaces.asd_reference_mm; }},
    {"surface_asd_test_mm", "surface ASD to reference mm", 3,
     "mean distance of the surface of the test to that of the reference, weighted by area",
     [](const C& c) { return c.surfaces.asd_test_mm; }},
    {"surface_reference_mm2", "reference surface mm2", 1, "area of the surface of the reference",
     [](const C& c) { return c.surfaces.area_reference_mm2; }},
    {"surface_test_mm2", "test surface mm2", 1, "area of the surface of the test",
     [](const C& c) { return c.surfaces.area_test_mm2; }},
};

}  // namespace

MaskComparison compare_masks(const Mask& reference, const Mask& test, double tolerance_mm) {
  return {compare(reference, test), compare_surfaces(reference, test, tolerance_mm)};
}

std::span<const Metric> metric_list() { return kMetrics; }

const Metric& metric_of(std::string_view key) {
  const auto found =
      std::find_if(std::begin(kMetrics), std::end(kMetrics), [&](const Metric& m) { return m.key == key; });
  SIMPLEXSEG_EXPECT(found != std::end(kMetrics));
  return *found;
}

}  // namespace simplexseg
