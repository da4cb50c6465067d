// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "field/box_image.h"
#include "field/evidence_settings.h"
#include "field/mark_classifier.h"
#include "field/marked_voxels.h"
#include "field/run_jobs.h"
#include "field/voxel_blocks.h"
#include "image/volume.h"

namespace simplexseg {

inline constexpr int kWidestBlock = 4;  ///< largest width of a block of the prior, cells

/// The image in a box on blocks of voxels, as the prior sees it.
struct CoarseImage {
  VoxelBlocks blocks;
  VolumeGeometry geometry;  ///< of the blocks
  std::array<double, 3> spacing_mm{};
  std::vector<float> smoothed;
  FeatureLists features;  ///< voxel_features.h
};
/// What is known of a block: what most of its voxels are, else `side`, which a voxel on a side of the box gives it.
SIMPLEXSEG_HD Constraint known_of_block(int outside, int not_finite, int voxels, Constraint side) {
  return 2 * not_finite >= voxels ? Constraint::NotFinite : 2 * outside >= voxels ? Constraint::Outside : side;
}
/// `side` of a block, as far as its voxels have been asked, with one more.
SIMPLEXSEG_HD Constraint side_with(Constraint side, Constraint voxel) {
  return voxel == Constraint::FarBorder || (voxel == Constraint::VolumeEdge && side == Constraint::None) ? voxel : side;
}
/// Mean of a block's voxels of a field before, of which `known` are not 0, which is: not known.
SIMPLEXSEG_HD std::uint8_t mean_before(int sum, int known) {
  return static_cast<std::uint8_t>(known == 0 ? 0 : (sum + known / 2) / known);
}

/// `volume`: its geometry; `first`: the box's first voxel; blocks as wide as fits an object of this scale.
CoarseImage coarse_image(const VolumeGeometry& volume, const BoxImage& image, const std::array<int, 3>& first,
                         double reach_mm, const EvidenceSettings& settings, const RunJobs& run);

}  // namespace simplexseg
