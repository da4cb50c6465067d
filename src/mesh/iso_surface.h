// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <span>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// The surface on which the values of a grid (i fastest) are `level`, above it inside; closed, whatever its topology:
/// beyond the grid everything is outside. Empty where no value is above. Marching tetrahedra, six to a cube (Doi and
/// Koide 1991), which never leave a hole; vertices keep a sixth of an edge away from grid points, so that no triangle
/// is a needle.
TriangleMesh iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                         const Eigen::Affine3d& mm_from_index);

/// The place near `mm` where the values, interpolated between the grid's places, are `level`: two steps along their
/// gradient (Newton's), none longer than half a cell. `mm` itself outside of the grid and where the values do not
/// change.
Eigen::Vector3d onto_iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                                 const Eigen::Affine3d& mm_from_index, const Eigen::Vector3d& mm);

}  // namespace simplexseg
