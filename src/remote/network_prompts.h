// SPDX-License-Identifier: Apache-2.0
// Prompts of a mesh as voxels of an image, and the mask that a network returns for them.
#pragma once
#include <array>
#include <vector>

#include "image/mask.h"
#include "session/network_mask.h"
#include "session/scene.h"

namespace simplexseg {

using VoxelIndex = std::array<int, 3>;  ///< indices along i, j, k of an image

/// Prompts that a segmentation server receives, as voxels of the image that was sent.
struct NetworkPrompts {
  std::vector<VoxelIndex> inside;  ///< the first is the centre of the seed
  std::vector<VoxelIndex> outside;
};

inline constexpr std::size_t kPointsOfStroke = 8;  ///< largest number of points sent for a stroke

/// Prompts of a mesh: the centre of its seed, and its inside and outside marks; points along strokes. Boundary marks,
/// paint, and marks outside the image are omitted. Throws Error for a seed outside the image.
NetworkPrompts prompts_of(const Scene& scene, const MeshItem& item, const VolumeGeometry& geometry);

/// Parts of a mask that contain an inside prompt, without the others, in the smallest box around them. Throws Error if
/// the mask is empty, or no part contains the seed.
PaintVoxels object_at_prompts(Mask mask, const NetworkPrompts& prompts);

}  // namespace simplexseg
