// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "field/box_image.h"
#include "field/evidence_settings.h"
#include "field/mark_classifier.h"
#include "field/marked_voxels.h"
#include "field/run_jobs.h"
#include "field/voxel_blocks.h"
#include "field/voxel_features.h"
#include "image/volume.h"

namespace simplexseg {

inline constexpr int kWidestBlock = 4;  ///< largest width of a block of the prior, cells

/// Image of a box on the blocks of the prior.
struct CoarseImage {
  VoxelBlocks blocks;
  VolumeGeometry geometry;  ///< of the blocks
  std::array<double, 3> spacing_mm{};
  std::vector<float> smoothed;
  FeatureLists features;  ///< voxel_features() of the image, then of each further one

  int images() const { return static_cast<int>(features.size() / kVoxelFeatures); }
};
/// Constraint of a block without the marks: NotFinite or Outside if at least half of its voxels are, else `side`.
SIMPLEXSEG_HD Constraint constraint_of_block(int outside, int not_finite, int voxels, Constraint side) {
  return 2 * not_finite >= voxels ? Constraint::NotFinite : 2 * outside >= voxels ? Constraint::Outside : side;
}
/// Constraint `side` of a block after one more of its voxels: FarBorder, VolumeEdge or None, in this precedence.
SIMPLEXSEG_HD Constraint side_constraint(Constraint side, Constraint voxel) {
  return voxel == Constraint::FarBorder || (voxel == Constraint::VolumeEdge && side == Constraint::None) ? voxel : side;
}
/// Mean of the previous field over the `count` voxels of a block where it is known, rounded; 0 (unknown) without any.
SIMPLEXSEG_HD std::uint8_t mean_of_previous(int sum, int count) {
  return static_cast<std::uint8_t>(count == 0 ? 0 : (sum + count / 2) / count);
}

/// Computes the image of a box whose first cell is `first`, on blocks with a width for an object of this scale.
/// `volume`: grid of all cells of the volume; `further`: further images of the same box. Source:
/// docs/mathematics.md 8.1.
CoarseImage coarse_image(const VolumeGeometry& volume, const BoxImage& image, const std::array<int, 3>& first,
                         double scale_mm, const EvidenceSettings& settings, const RunJobs& run,
                         std::span<const BoxImage> further = {});

}  // namespace simplexseg
