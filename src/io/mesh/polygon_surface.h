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
  CellList polygons;                       ///< consistently oriented
};

/// Callback that throws the Error for a file; `why`: its cause.
using Fail = std::function<void(const std::string& why)>;

/// Neighbours of each vertex of a simplex mesh whose cells are the polygons, counter-clockwise seen from outside. Calls
/// `fail` if a vertex does not belong to three polygons, or its polygons do not form a cycle.
std::vector<std::array<int, 3>> neighbours_of(const PolygonSurface& surface, const Fail& fail);

/// Simplex mesh of a closed surface, oriented outwards. If each vertex belongs to three polygons, not all triangles,
/// the polygons are its cells; otherwise it is the dual of the triangulation (polygons are split into triangles from
/// their first corner). If triangles do not share vertices, bitwise equal positions are merged. Calls `fail` with the
/// first offending edge if the surface is open, non-manifold or inconsistently oriented.
SimplexMesh simplex_mesh_of(PolygonSurface surface, const Fail& fail);

}  // namespace simplexseg
