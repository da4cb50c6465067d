// SPDX-License-Identifier: Apache-2.0
#include "image/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "image/distance_map.h"

namespace simplexseg {
namespace {

std::string size_text(const VolumeGeometry& g) {
  return std::to_string(g.size[0]) + " x " + std::to_string(g.size[1]) + " x " + std::to_string(g.size[2]);
}

struct Counts {
  std::size_t reference = 0, test = 0, both = 0;
  double dice() const { return reference + test == 0 ? 1.0 : 2.0 * both / static_cast<double>(reference + test); }
};

Counts count(const Mask& reference, const Mask& test) {
  Counts counts;
  for (std::size_t v = 0; v < reference.voxels.size(); ++v) {
    const bool a = reference.voxels[v] != 0, b = test.voxels[v] != 0;
    counts.reference += a;
    counts.test += b;
    counts.both += a && b;
  }
  return counts;
}

/// Mask of the boundary voxels: those with a 6-neighbour outside the mask or outside the image.
std::vector<std::uint8_t> boundary_of(const Mask& mask, const VoxelBox& box) {
  const auto [ni, nj, nk] = mask.geometry.size;
  const std::vector<std::uint8_t> outside(ni, 0);
  const auto row = [&, ni = ni, nj = nj, nk = nk](int j, int k) {
    return j < 0 || j >= nj || k < 0 || k >= nk ? outside.data()
                                                : mask.voxels.data() + (static_cast<std::size_t>(k) * nj + j) * ni;
  };
  std::vector<std::uint8_t> boundary(box.voxel_count());
  for (int k = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      const int gj = box.first[1] + j, gk = box.first[2] + k;
      const std::uint8_t *here = row(gj, gk), *below = row(gj - 1, gk), *above = row(gj + 1, gk);
      const std::uint8_t *before = row(gj, gk - 1), *behind = row(gj, gk + 1);
      std::uint8_t* out = boundary.data() + box.offset(0, j, k);
      for (int i = 0; i < box.size[0]; ++i) {
        const int gi = box.first[0] + i;
        if (!here[gi]) continue;
        const bool inner =
            gi > 0 && gi + 1 < ni && here[gi - 1] && here[gi + 1] && below[gi] && above[gi] && before[gi] && behind[gi];
        out[i] = !inner;
      }
    }
  }
  return boundary;
}

}  // namespace

void require_same_grid(const Mask& reference, const Mask& test) {
  for (const Mask* mask : {&reference, &test}) {
    if (mask->voxels.size() != mask->geometry.voxel_count())
      throw Error("mask",
                  "it has " + std::to_string(mask->voxels.size()) + " voxels on a grid of " + size_text(mask->geometry),
                  "create it with mask_of or rasterise");
  }
  if (!reference.geometry.same_grid(test.geometry)) {
    const bool same_size = reference.geometry.size == test.geometry.size;
    throw Error("masks cannot be compared",
                same_size ? "their grids have the same size but different positions"
                          : "their grids differ (" + size_text(reference.geometry) + " against " +
                                size_text(test.geometry) + ")",
                "resample one mask onto the grid of the other");
  }
}

double dice(const Mask& reference, const Mask& test) {
  require_same_grid(reference, test);
  return count(reference, test).dice();
}

Agreement compare(const Mask& reference, const Mask& test) {
  require_same_grid(reference, test);
  const Counts counts = count(reference, test);
  const Eigen::Matrix3d mm_from_index = reference.geometry.world_from_index().linear();
  const double voxel_mm3 = std::abs(mm_from_index.determinant());
  Agreement result{};
  result.dice = counts.dice();
  result.reference_mm3 = counts.reference * voxel_mm3;
  result.test_mm3 = counts.test * voxel_mm3;
  if (counts.reference == 0 && counts.test == 0) return result;
  if (counts.reference == 0 || counts.test == 0) {
    result.hd_mm = result.hd95_mm = result.assd_mm = kInfinity;
    result.hd_directed_mm = result.hd95_directed_mm = result.asd_directed_mm = kInfinity;
    return result;
  }
  const VoxelBox box = bounding_box(reference, test);
  const std::vector<std::uint8_t> reference_boundary = boundary_of(reference, box);
  const std::vector<std::uint8_t> test_boundary = boundary_of(test, box);

  std::vector<double> to_test = distances_between(reference_boundary, test_boundary, box, mm_from_index);
  std::vector<double> to_reference = distances_between(test_boundary, reference_boundary, box, mm_from_index);
  const DistanceSummary forward = summarise(to_test), backward = summarise(to_reference);
  result.hd_directed_mm = forward.max;
  result.hd95_directed_mm = forward.percentile95;
  result.asd_directed_mm = forward.mean;
  result.hd_mm = std::max(forward.max, backward.max);
  result.hd95_mm = std::max(forward.percentile95, backward.percentile95);
  result.assd_mm = 0.5 * (forward.mean + backward.mean);
  return result;
}

}  // namespace simplexseg
