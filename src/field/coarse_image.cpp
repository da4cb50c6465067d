// SPDX-License-Identifier: Apache-2.0
#include "field/coarse_image.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace simplexseg {
namespace {

constexpr int kLeastBlocks = 8;    // along an axis
constexpr double kRoundUp = 0.25;  // widths of n + 0.75 or more are rounded up

std::array<int, 3> width_for(const VolumeGeometry& volume, const BoxGrid& grid, double scale_mm,
                             const EvidenceSettings& settings) {
  const double least = volume.spacing_mm.minCoeff();
  const int cells =
      std::clamp(static_cast<int>(scale_mm / least / settings.blocks_per_scale + kRoundUp), 1, kWidestBlock);
  std::array<int, 3> width;
  for (int a = 0; a < 3; ++a) {
    width[a] = std::max(1, static_cast<int>(std::lround(cells * least / volume.spacing_mm[a])));
    width[a] = std::clamp(grid.size[a] / kLeastBlocks, 1, width[a]);
  }
  return width;
}

}  // namespace

CoarseImage coarse_image(const VolumeGeometry& volume, const BoxImage& image, const std::array<int, 3>& first,
                         double scale_mm, const EvidenceSettings& settings, const RunJobs& run,
                         std::span<const BoxImage> further) {
  CoarseImage coarse{VoxelBlocks(image.grid, width_for(volume, image.grid, scale_mm, settings)), {}, {}, {}, {}};
  const BoxGrid& grid = coarse.blocks.coarse;
  coarse.geometry = coarse.blocks.geometry(volume, first);
  for (int a = 0; a < 3; ++a) coarse.spacing_mm[a] = coarse.geometry.spacing_mm[a];
  coarse.smoothed = coarse.blocks.mean(image.value, run);
  coarse.features = voxel_features(coarse.smoothed, grid, coarse.spacing_mm, run);
  for (const BoxImage& other : further)
    for (std::vector<float>& feature :
         voxel_features(coarse.blocks.mean(other.value, run), grid, coarse.spacing_mm, run))
      coarse.features.push_back(std::move(feature));
  smooth_by_least_spacing(coarse.smoothed, grid, coarse.spacing_mm, settings.image_smoothing, run);
  return coarse;
}

}  // namespace simplexseg
