// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <span>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Closed surface (mm) at which the values of a grid (i fastest) equal `level`. Larger values are inside; the space
/// beyond the grid is outside. Empty if no value exceeds the level. Marching tetrahedra, with six tetrahedra in each
/// cube (Doi and Koide 1991), leaves no holes. Vertices are moved along grid edges to at least a sixth of the edge from
/// its ends, which avoids needle triangles.
TriangleMesh iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                         const Eigen::Affine3d& mm_from_index);

/// Projects the position `mm` onto the level set of the trilinearly interpolated values: two Newton steps along the
/// gradient, each of at most half a cell along every axis. Stops early outside the grid or where the gradient is 0.
Eigen::Vector3d project_onto_iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                                         const Eigen::Affine3d& mm_from_index, const Eigen::Vector3d& mm);

}  // namespace simplexseg
