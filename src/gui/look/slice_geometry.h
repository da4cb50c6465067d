// SPDX-License-Identifier: Apache-2.0
// Position of the three slices in the patient frame (LPS, mm) and their orientation on the screen.
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

/// Radiological: the patient's right is on the left of the screen, as seen from the feet or from the front.
enum class Convention { Radiological, Neurological };

/// Axes of a slice on the screen; unit vectors in LPS.
struct SliceAxes {
  int normal;                 ///< world axis (0 x, 1 y, 2 z) orthogonal to the slice
  Eigen::Vector3d right, up;  ///< directions to the right and up on the screen
};
SliceAxes slice_axes(Orientation orientation, Convention convention);
/// Letter of the patient's side ('L', 'R', 'P', 'A', 'S' or 'I') nearest to `direction`, which must not be zero.
char letter_of(const Eigen::Vector3d& direction);

/// Bounding box of all voxels in the patient frame, up to their outer faces.
struct WorldBox {
  Eigen::Vector3d low_mm{0, 0, 0}, high_mm{0, 0, 0};
  Eigen::Vector3d centre_mm() const { return (low_mm + high_mm) / 2; }
  Eigen::Vector3d extent_mm() const { return high_mm - low_mm; }
};
WorldBox world_box(const VolumeGeometry& geometry);
/// Returns true if every voxel axis is parallel to a world axis, within 0.1 voxels at its end: slices then need no
/// interpolation.
bool is_axis_aligned(const VolumeGeometry& geometry);
/// Slice spacing along each world axis, mm: the spacing of the voxel axis nearest to that world axis.
Eigen::Vector3d slice_spacing_mm(const VolumeGeometry& geometry);
/// Number of decimals of a position in mm that resolves a tenth of the finest spacing; at least 1, at most 6.
int position_decimals(const VolumeGeometry& geometry);
/// Number of a slice, counted from 1 along increasing world coordinates, number of all slices, and their spacing.
struct SliceNumber {
  int number, count;
  double spacing_mm;
};
SliceNumber slice_number(const VolumeGeometry& geometry, Orientation orientation, const Eigen::Vector3d& at_mm);
/// Nearest voxel centre, clamped to the volume; for a volume that is not axis-aligned, the nearest point of its box.
Eigen::Vector3d snap_to_voxel(const VolumeGeometry& geometry, const Eigen::Vector3d& world_mm);

/// Texel grid of a slice: texel (0, 0) is centred at `origin_mm`; rows extend along `step_u_mm`.
struct SliceGrid {
  Eigen::Vector3d origin_mm{0, 0, 0}, step_u_mm{1, 0, 0}, step_v_mm{0, 1, 0};
  int width = 0, height = 0;
  bool operator==(const SliceGrid&) const = default;
  /// Outer corner of the first texel.
  Eigen::Vector3d corner_mm() const { return origin_mm - 0.5 * (step_u_mm + step_v_mm); }
};
/// Grid of the whole slice through `through_mm`, with rows and columns along increasing world axes; at most 2048 texels
/// per side. With an odd `texels_per_voxel` (at least 1, per axis), one texel lies on the centre of each voxel.
SliceGrid slice_grid(const VolumeGeometry& geometry, Orientation orientation, const Eigen::Vector3d& through_mm,
                     int texels_per_voxel = 1);
/// Number of texels per voxel and axis, for slice_grid(). Above 1 for small volumes, whose voxels are larger than
/// pixels: intensities are then interpolated before windowing, so that edges stay in place when the window clips them.
int texels_per_voxel(const VolumeGeometry& geometry);
/// Texel grid in voxel index space, as an engine draws it; exact on voxel centres. Intensities level -+ window/2 become
/// black and white; `window` is above 0.
SlicePlane slice_plane(const VolumeGeometry& geometry, const SliceGrid& grid, double window, double level);

}  // namespace simplexseg
