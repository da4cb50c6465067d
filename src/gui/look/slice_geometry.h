// SPDX-License-Identifier: Apache-2.0
// Where the three slices lie in the patient frame (LPS, mm) and how they are laid on the screen.
#pragma once
#include <Eigen/Core>
#include <array>

#include "image/volume.h"
#include "step/display.h"

namespace simplexseg {

enum class Orientation : int { Axial, Sagittal, Coronal };
inline constexpr std::array<Orientation, 3> kOrientations{Orientation::Axial, Orientation::Sagittal,
                                                          Orientation::Coronal};
const char* title_of(Orientation orientation);

/// Radiological: the patient's right is on the left of the screen, as if seen from the feet or from the front.
enum class Convention { Radiological, Neurological };

/// How a slice lies on the screen; unit vectors in LPS.
struct SliceAxes {
  int normal;                 ///< world axis (0 x, 1 y, 2 z) that the slice is orthogonal to
  Eigen::Vector3d right, up;  ///< on the screen
};
SliceAxes slice_axes(Orientation orientation, Convention convention);
/// 'L', 'R', 'P', 'A', 'S' or 'I': the side of the patient that a direction, not zero, points to most.
char letter_of(const Eigen::Vector3d& direction);

/// The box in the patient frame that holds all voxels, outer faces included.
struct WorldBox {
  Eigen::Vector3d low_mm{0, 0, 0}, high_mm{0, 0, 0};
  Eigen::Vector3d centre_mm() const { return (low_mm + high_mm) / 2; }
  Eigen::Vector3d extent_mm() const { return high_mm - low_mm; }
};
WorldBox world_box(const VolumeGeometry& geometry);
/// True when every voxel axis runs along a world axis: slices are then voxel rows, not interpolated.
bool is_axis_aligned(const VolumeGeometry& geometry);
/// Distance of neighbouring slices along the world axes: the spacing of the voxel axis nearest to each.
Eigen::Vector3d slice_spacing_mm(const VolumeGeometry& geometry);
/// Which slice of how many, from 1, along increasing world coordinates.
struct SliceNumber {
  int number, count;
  double spacing_mm;
};
SliceNumber slice_number(const VolumeGeometry& geometry, Orientation orientation, const Eigen::Vector3d& at_mm);
/// The nearest voxel centre, clamped to the volume; for a volume that is not axis-aligned, the nearest point of its
/// box.
Eigen::Vector3d snap_to_voxel(const VolumeGeometry& geometry, const Eigen::Vector3d& world_mm);

/// The texels of a slice: texel (0, 0) is centred at `origin_mm`, rows run along `step_u_mm`.
struct SliceGrid {
  Eigen::Vector3d origin_mm{0, 0, 0}, step_u_mm{1, 0, 0}, step_v_mm{0, 1, 0};
  int width = 0, height = 0;
  /// The outer corner of the first texel.
  Eigen::Vector3d corner_mm() const { return origin_mm - 0.5 * (step_u_mm + step_v_mm); }
};
/// The whole plane through `through_mm`, rows and columns along increasing world axes; at most 2048 texels a side. With
/// an odd number of texels for each voxel and axis (at least 1) one of them is on the voxel's centre.
SliceGrid slice_grid(const VolumeGeometry& geometry, Orientation orientation, const Eigen::Vector3d& through_mm,
                     int texels_per_voxel = 1);
/// How many texels a voxel gets along each axis, for slice_grid. More than 1 in a small volume, whose voxels are larger
/// than pixels: then the intensity is interpolated between voxels rather than its grey, and edges beyond the window
/// stay where they are.
int texels_per_voxel(const VolumeGeometry& geometry);
/// The same texels in voxel index space, as an engine draws them: exactly on the voxels' centres where the grid meets
/// them. Intensities level -+ window/2 become black and white; the window is above 0.
SlicePlane slice_plane(const VolumeGeometry& geometry, const SliceGrid& grid, double window, double level);

}  // namespace simplexseg
