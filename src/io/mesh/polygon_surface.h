// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Polygons read from a file.
struct PolygonSurface {
  std::vector<Eigen::Vector3f> positions;  ///< mm, LPS
  CellList polygons;                       ///< consistently oriented, as seen from outside
};

/// Callback that throws the Error for a file and never returns. `why`: cause.
using Fail = std::function<void(const std::string& why)>;

/// Neighbours of each vertex of the simplex mesh whose cells are the polygons, counter-clockwise seen from outside if
/// the polygons are. Calls `fail` if a vertex does not belong to three polygons, or its polygons do not form a cycle.
std::vector<std::array<int, 3>> neighbours_of(const PolygonSurface& surface, const Fail& fail);

/// Simplex mesh of a closed surface, oriented outwards. If each vertex belongs to three polygons and not all polygons
/// are triangles, the polygons are the cells of the mesh. Otherwise the mesh is the dual of the triangulation, for
/// which polygons are split into triangles from their first corner; if polygons share no vertices, vertices with equal
/// positions are merged first. Calls `fail` if there are no polygons, a position is not finite, or the surface is open,
/// non-manifold or inconsistently oriented (with the first such edge).
SimplexMesh simplex_mesh_of(PolygonSurface surface, const Fail& fail);

}  // namespace simplexseg
