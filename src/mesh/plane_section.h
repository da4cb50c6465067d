// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// A closed polygon; its last corner is joined to its first.
using Polygon = std::vector<Eigen::Vector2d>;

/// What the planes k = 0 .. planes - 1 of a grid cut out of a closed surface: for each plane the polygons in (i, j),
/// those around the solid counter-clockwise, those around its holes clockwise, whatever the handedness of
/// `index_from_world`. Exact sections of the tessellated surface (tessellate()).
std::vector<std::vector<Polygon>> plane_sections(const SimplexMesh& mesh, const Eigen::Affine3d& index_from_world,
                                                 int planes);

/// Twice the area that a polygon runs around, > 0 counter-clockwise.
double doubled_area(const Polygon& polygon);

/// The same area without holes: each is joined to the polygon around it by a cut of no width, from corner to corner
/// where they are nearest (the keyhole of DICOM PS3.3 C.8.8.6.3).
std::vector<Polygon> with_keyholes(std::vector<Polygon> polygons);

}  // namespace simplexseg
