// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "image/paint_voxels.h"
#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Voxels of the object of a mesh (object_mask()) that an edit changes. `size`: VoxelEditInfo::size; `other`: the other
/// object, or null. Throws Error if the edit changes nothing or would remove the whole object, the size is out of
/// range, or the other object is missing.
std::shared_ptr<const PaintVoxels> edited_voxels(const Scene& scene, const MeshItem& item, VoxelEdit edit, double size,
                                                 const MeshItem* other, const VolumeGeometry& grid);

/// Voxels that an edit sets under a stroke of paint.
/// - Freeze: the voxels under the stroke, with their present state, except those whose label is that of another object.
/// - SmartPaint: those that are connected to the path (across faces) through voxels with similar intensities: within
///   3 robust standard deviations (1.4826 median absolute deviations) of the median within half of the radius of the
///   path; and the cavities in them.
/// Throws Error if the stroke covers no voxel of the image.
std::shared_ptr<const PaintVoxels> stroked_voxels(const Scene& scene, const MeshItem& item, const UserPoint& stroke,
                                                  const Volume& volume);

}  // namespace simplexseg
