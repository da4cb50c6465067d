// SPDX-License-Identifier: Apache-2.0
// Region of interest of a field: first box, cells and automatic growth.
#pragma once
#include <array>
#include <span>

#include "field/evidence_settings.h"
#include "field/marks.h"
#include "image/cell_grid.h"
#include "image/distance_map.h"
#include "image/volume.h"

namespace simplexseg {

/// Bounding box of the marks, within the volume, with a margin: the larger of a share of their largest extent and of
/// `least_margin` times the smallest spacing.
VoxelBox box_around_marks(std::span<const Mark> marks, const VolumeGeometry& geometry, double margin_share,
                          double least_margin);

/// Largest extent of the inside and boundary marks along an axis of the patient frame, mm.
double marked_extent(std::span<const Mark> marks);

/// Bounding box of a box in the patient frame (two opposite corners, mm), within the volume, with a margin of
/// `least_margin` times the smallest spacing.
VoxelBox box_around_bounds(const std::array<Eigen::Vector3d, 2>& corners_mm, const VolumeGeometry& geometry,
                           double least_margin);

/// Smallest box that contains two others; a box of size 0 is ignored.
VoxelBox box_around(const VoxelBox& a, const VoxelBox& b);

/// Size of the cells for an object of this scale (seed_scale()) in a box of voxels: one voxel, or the smallest size
/// with which the box has at most EvidenceSettings::max_cells and a block of the prior is an integer number of cells
/// wide, at most kWidestBlock. Blocks, and thus the result, then hardly depend on the spacing of the image. All edges
/// of a cell have the same length (mm), except along axes with larger voxels.
CellSize cell_size_for(const VoxelBox& voxels, const VolumeGeometry& volume, double scale_mm,
                       const EvidenceSettings& settings);

/// Moves each side of a box that is nearer to the bounding box of the object than 0.15 of its extent or 5 of the
/// smallest voxels, to 0.3 of the extent or 10 voxels, at most to the side of the volume. Returns `box` if there is no
/// such side.
VoxelBox grow_around(const VoxelBox& box, const VoxelBox& object, const VolumeGeometry& geometry);

/// Whether an object with this volume and bounding box (in cells) fills less than a fifth of that box, like a curved
/// tube or a shell, or is a straight tube or a flat plate. `cell_mm`: edges of a cell.
bool is_thin(double mm3, const VoxelBox& bounds, const Eigen::Vector3d& cell_mm);

/// Volumes of an object in boxes that grow. An object whose volume is constant from one box to the next, by at most 5%,
/// is complete; if the volume increases by 30% in later boxes, the object spreads through a narrow connection.
class VolumeInBoxes {
 public:
  /// Adds the volume in the next box, mm^3; replaces it if the box is the last one. Returns whether the object spreads;
  /// constant_in() then is the box in which it was complete.
  bool add(double mm3, const VoxelBox& box);
  const VoxelBox& constant_in() const { return constant_in_; }

 private:
  double last_mm3_ = 0, constant_mm3_ = 0;
  VoxelBox last_in_{}, constant_in_{};
};

}  // namespace simplexseg
