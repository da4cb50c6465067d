// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <string_view>
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

/// Whether the comments of a file contain SPACE=RAS: its coordinates are RAS instead of LPS.
bool states_ras(std::string_view comments);
/// Converts positions from RAS to LPS.
void convert_from_ras(std::vector<Eigen::Vector3f>& positions);

/// Neighbours of each vertex of the simplex mesh whose cells are the polygons, counter-clockwise seen from outside if
/// the polygons are. Calls `fail` if a vertex does not belong to three polygons, or its polygons do not form a cycle.
std::vector<std::array<int, 3>> neighbours_of(const PolygonSurface& surface, const Fail& fail);

/// Simplex mesh of a closed surface, oriented outwards: an outermost part that faces inward is turned together with the
/// parts inside it. If each vertex belongs to three polygons and not all polygons are triangles, the polygons are the
/// cells of the mesh. Otherwise the mesh is the dual of the triangulation, for which polygons, also concave ones, are
/// split into triangles; if polygons share no vertices, vertices with equal positions are merged first. The dual of a
/// coarse triangulation encloses less: triangles are split into four until the volume differs by at most 2%. Calls
/// `fail` if there are no polygons, a position is not finite, or the surface is open, non-manifold or inconsistently
/// oriented (with the first such edge).
SimplexMesh simplex_mesh_of(PolygonSurface surface, const Fail& fail);

}  // namespace simplexseg
