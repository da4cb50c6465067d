// SPDX-License-Identifier: Apache-2.0
// Edits of the voxels of an object: of all of them, or of those under a stroke. Their result is paint.
#pragma once
#include <cstdint>
#include <span>

#include "forces/parameters.h"

namespace simplexseg {

enum class VoxelEdit : std::uint8_t {
  None,
  KeepLargest,  ///< removes all connected parts but the largest
  RemoveSmall,  ///< removes the parts smaller than a volume
  FillHoles,    ///< fills the cavities
  Margin,       ///< moves the surface outwards by a distance, or inwards
  Smooth,       ///< smooths the surface
  Add,          ///< adds the voxels of another object
  Subtract,     ///< removes the voxels of another object
  Intersect,    ///< removes the voxels that do not belong to another object
  SmartPaint,   ///< sets the voxels under a stroke whose intensities are those along its path
  Freeze,       ///< sets the voxels under a stroke to their present state, so that no later mark changes them
};

/// Description of an edit.
struct VoxelEditInfo {
  VoxelEdit edit;
  const char* name;    ///< name in files, in snake_case
  const char* title;   ///< text of the list of actions, in lower case
  const char* doc;     ///< description in one sentence, shown as tooltip
  bool uses_stroke;    ///< whether it needs the stroke of a brush (AddPoint) instead of EditVoxels
  bool uses_other;     ///< whether it needs another object
  ParameterInfo size;  ///< size of the edit; name "" if it has none
};

/// All edits but None, in the order of VoxelEdit.
std::span<const VoxelEditInfo> voxel_edits();
const VoxelEditInfo& info_of(VoxelEdit edit);

}  // namespace simplexseg
