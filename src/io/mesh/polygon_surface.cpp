// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/polygon_surface.h"

#include <algorithm>
#include <array>
#include <map>

#include "core/error.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

bool are_triangles(const CellList& polygons) {
  for (int c = 0; c < polygons.count(); ++c)
    if (polygons[c].size() != 3) return false;
  return true;
}

/// Whether each vertex belongs to three polygons, as in a simplex mesh.
bool are_cells(const PolygonSurface& surface) {
  std::vector<int> count(surface.positions.size());
  for (const int v : surface.polygons.vertices) ++count[v];
  return std::all_of(count.begin(), count.end(), [](int n) { return n == 3; });
}

/// Merges vertices with equal positions.
void weld(PolygonSurface& surface) {
  std::map<std::array<float, 3>, int> places;
  std::vector<Eigen::Vector3f> positions;
  std::vector<int> index;
  for (const Eigen::Vector3f& p : surface.positions) {
    const auto [found, is_new] = places.try_emplace({p[0], p[1], p[2]}, static_cast<int>(positions.size()));
    if (is_new) positions.push_back(p);
    index.push_back(found->second);
  }
  surface.positions = std::move(positions);
  for (int& v : surface.polygons.vertices) v = index[v];
}

TriangleMesh triangles_of(const PolygonSurface& surface) {
  TriangleMesh triangles{surface.positions, {}};
  for (int c = 0; c < surface.polygons.count(); ++c) {
    const auto polygon = surface.polygons[c];
    for (std::size_t n = 2; n < polygon.size(); ++n) {
      const std::array<int, 3> t{polygon[0], polygon[n - 1], polygon[n]};
      // A triangle with two identical corners is omitted: the surface is closed without it.
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.triangles.push_back(t);
    }
  }
  return triangles;
}

}  // namespace

std::vector<std::array<int, 3>> neighbours_of(const PolygonSurface& surface, const Fail& fail) {
  // In a polygon with consecutive corners a, v, b, the edge to a follows the edge to b counter-clockwise around v.
  struct Turn {
    int from, to;
  };
  const std::size_t vertices = surface.positions.size();
  std::vector<std::array<Turn, 3>> turns(vertices);
  std::vector<int> filled(vertices, 0);
  for (int c = 0; c < surface.polygons.count(); ++c) {
    const auto cell = surface.polygons[c];
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const int v = cell[i];
      if (filled[v] == 3) fail("vertex " + std::to_string(v) + " belongs to more than three polygons");
      turns[v][filled[v]++] = {cell[(i + 1) % cell.size()], cell[(i + cell.size() - 1) % cell.size()]};
    }
  }
  std::vector<std::array<int, 3>> neighbours(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    if (filled[v] != 3)
      fail("vertex " + std::to_string(v) + " belongs to " + std::to_string(filled[v]) + " polygons instead of three");
    const auto& t = turns[v];
    // The three turns must form a cycle: first.to == second.from and so on, in one of the two orders.
    const int second = t[1].from == t[0].to ? 1 : 2, third = 3 - second;
    if (t[second].from != t[0].to || t[third].from != t[second].to || t[0].from != t[third].to) {
      fail("the polygons around vertex " + std::to_string(v) + " do not close");
    }
    neighbours[v] = {t[0].from, t[second].from, t[third].from};
  }
  return neighbours;
}

SimplexMesh simplex_mesh_of(PolygonSurface surface, const Fail& fail) {
  if (surface.polygons.count() == 0) fail("it has no polygons");
  for (const Eigen::Vector3f& p : surface.positions)
    if (!p.allFinite()) fail("a position is not finite");
  SimplexMesh mesh;
  if (!are_triangles(surface.polygons) && are_cells(surface)) {
    mesh.neighbours = neighbours_of(surface, fail);
    mesh.positions = std::move(surface.positions);
  } else {
    if (surface.positions.size() == surface.polygons.vertices.size()) weld(surface);
    try {
      mesh = dual_of(triangles_of(surface));
    } catch (const Error& error) {
      const std::string why = error.what();  // without the remedy: `fail` adds another one
      fail(why.substr(0, why.rfind("; ")));
    }
  }
  if (measure(mesh).volume_mm3 < 0)
    for (auto& n : mesh.neighbours) std::swap(n[1], n[2]);
  return mesh;
}

}  // namespace simplexseg
