// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <span>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Closed surface at which the values of a grid (i fastest) equal `level`. Larger values are inside; the space beyond
/// the grid is outside. Empty if no value exceeds the level. Marching tetrahedra, six for each cube (Doi and Koide
/// 1991), leave no holes. Vertices lie at least a sixth of an edge from grid points, which avoids needle triangles.
TriangleMesh iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                         const Eigen::Affine3d& mm_from_index);

/// Projects the position `mm` onto the level set of the trilinearly interpolated values: two Newton steps along the
/// gradient, each of at most half a cell. Returns `mm` unchanged outside the grid and where the gradient is zero.
Eigen::Vector3d project_onto_iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                                         const Eigen::Affine3d& mm_from_index, const Eigen::Vector3d& mm);

}  // namespace simplexseg
