// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Corners of a closed polygon, whose last corner is joined to the first.
using Polygon = std::vector<Eigen::Vector2d>;

/// Sections of the tessellated surface (tessellate()) with the planes k = 0 .. planes - 1 of a grid: for each plane the
/// polygons in voxel indices (i, j). Outer boundaries run counter-clockwise and holes clockwise, for either handedness
/// of `index_from_world`. Omits polygons of less than 5e-7 square voxels.
std::vector<std::vector<Polygon>> plane_sections(const SimplexMesh& mesh, const Eigen::Affine3d& index_from_world,
                                                 int planes);

/// Twice the signed area of a polygon, in the squared unit of its corners; > 0 if counter-clockwise.
double doubled_area(const Polygon& polygon);

/// Removes holes: joins each hole to the polygon around it by a channel of zero width between their nearest corners
/// (the keyhole technique of DICOM PS3.3 C.8.8.6.3).
std::vector<Polygon> with_keyholes(std::vector<Polygon> polygons);

}  // namespace simplexseg
