// SPDX-License-Identifier: Apache-2.0
// Prompts of a mesh as voxels of an image, and the mask that a network returns for them.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "image/mask.h"
#include "image/paint_stroke.h"
#include "session/network_mask.h"
#include "session/scene.h"

namespace simplexseg {

using VoxelIndex = std::array<int, 3>;  ///< indices along i, j, k of an image

/// Stroke that a segmentation server receives as voxels.
struct NetworkScribble {
  bool inside = true;   ///< whether it marks the object; otherwise the background
  StrokeVoxels voxels;  ///< at least one of them is set
};

/// Prompts that a segmentation server receives, as voxels of the image that was sent.
struct NetworkPrompts {
  std::vector<VoxelIndex> inside;  ///< the first is the centre of the seed
  std::vector<VoxelIndex> outside;
  std::vector<NetworkScribble> scribbles{};
};

inline constexpr std::size_t kPointsOfStroke = 8;  ///< largest number of points sent for a stroke

/// Prompts of a mesh: the centre of its seed, and its inside and outside marks. Strokes, also those of boxes and
/// lassos, are scribbles of a thickness of `scribble_voxels`, or points along them for 0. Boundary marks, paint, and
/// marks outside the image are omitted. Throws Error for a seed outside the image.
NetworkPrompts prompts_of(const Scene& scene, const MeshItem& item, const VolumeGeometry& geometry,
                          int scribble_voxels = 0);
/// Numbers of prompts for the user: "3 points and 1 scribble".
std::string text_of(const NetworkPrompts& prompts);

/// Parts of a mask that contain an inside prompt, without the others, in the smallest box around them. Throws Error if
/// the mask is empty, or no part contains the seed.
PaintVoxels object_at_prompts(Mask mask, const NetworkPrompts& prompts);

}  // namespace simplexseg
