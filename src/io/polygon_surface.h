// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Polygons as files hold them, of whatever program.
struct PolygonSurface {
  std::vector<Eigen::Vector3f> positions;  ///< mm, LPS
  CellList polygons;                       ///< all of one sense
};

/// Throws the Error for a file, given why.
using Refuse = std::function<void(const std::string& why)>;

/// The neighbours of polygons that are the cells of a simplex mesh, counter-clockwise from outside. Refuses a vertex
/// that is not in three of them, and polygons that do not close around one.
std::vector<std::array<int, 3>> neighbours_of(const PolygonSurface& surface, const Refuse& refuse);

/// The simplex mesh of a closed surface: where each vertex is in three polygons, not all of them triangles, these are
/// its cells; else the dual of the triangulation (polygons cut into triangles from their first corner), turned so that
/// it is outward. Corners that each triangle has for itself are joined where they are equal to the bit. Refuses a
/// surface that is open, not manifold or of mixed sense, naming the first edge.
SimplexMesh simplex_mesh_of(PolygonSurface surface, const Refuse& refuse);

}  // namespace simplexseg
