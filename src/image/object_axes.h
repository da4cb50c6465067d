// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>

#include "image/volume.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Long and short axis of an object in one axial slice.
struct ObjectAxes {
  std::array<Eigen::Vector3d, 2> long_ends_mm, short_ends_mm;  ///< ends, LPS, mm
  int slice = 0;  ///< number of the slice, from 1, the lowest (towards the feet), as in the window

  double long_mm() const { return (long_ends_mm[1] - long_ends_mm[0]).norm(); }
  double short_mm() const { return (short_ends_mm[1] - short_ends_mm[0]).norm(); }
};

/// Long and short axis of the object that a mesh encloses, as RECIST 1.1 measures lesions and lymph nodes: the long
/// axis is its longest diameter in any axial slice, the short axis the longest diameter perpendicular to it in the same
/// slice, mm. Slices are planes of the grid through voxel centres, across the voxel axis nearest to the patient's
/// longitudinal axis. A diameter joins two points of the outer contour of one connected part of the section; it can
/// leave the object where that is concave. Computed from the contours of the surface, without voxels. nullopt if no
/// slice cuts the mesh. Eisenhauer et al. 2009, New response evaluation criteria in solid tumours: revised RECIST
/// guideline (version 1.1), Eur J Cancer 45:228-247.
std::optional<ObjectAxes> object_axes(const SimplexMesh& mesh, const VolumeGeometry& geometry);

}  // namespace simplexseg
