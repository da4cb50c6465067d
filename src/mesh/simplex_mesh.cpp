// SPDX-License-Identifier: Apache-2.0
#include "mesh/simplex_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_set>

#include "core/error.h"
#include "core/expect.h"
#include "core/number_text.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

constexpr int kMaxSphereLevel = 11;           // 84 million vertices
constexpr int kMaxRefinedVertices = 1 << 27;  // largest number V of coarse vertices: 3 x 4V corners fit into an int

int next_slot(int slot) { return slot == 2 ? 0 : slot + 1; }
int previous_slot(int slot) { return slot == 0 ? 2 : slot - 1; }

/// Slot of `neighbour` among the neighbours of `vertex`; -1 if the two are not neighbours.
int slot_of(const std::vector<std::array<int, 3>>& neighbours, int vertex, int neighbour) {
  const auto& n = neighbours[vertex];
  return n[0] == neighbour ? 0 : n[1] == neighbour ? 1 : n[2] == neighbour ? 2 : -1;
}

[[noreturn]] void throw_invalid(int vertex, const std::string& why) {
  throw Error("vertex " + std::to_string(vertex) + " of the simplex mesh", why,
              "repair the mesh, or create it again as the dual of a closed triangulation that is oriented outwards");
}

std::string edge_name(int a, int b) { return std::to_string(a) + "-" + std::to_string(b); }

/// Cells of a mesh, and the cell of each corner 3v + s, between the slots s and s+1 of vertex v. Counter-clockwise, the
/// boundary of a cell leaves v through slot s and arrives through slot s+1; after arriving through slot r it continues
/// through slot r-1.
CellList trace_cells(const SimplexMesh& mesh, std::vector<int>& cell_of_corner) {
  const auto& neighbours = mesh.neighbours;
  const int count = static_cast<int>(neighbours.size());
  CellList cells;
  cells.vertices.reserve(3 * neighbours.size());
  cells.offsets.reserve(neighbours.size() / 2 + 3);
  cell_of_corner.assign(3 * neighbours.size(), -1);
  for (int start = 0; start < count; ++start) {
    for (int start_slot = 0; start_slot < 3; ++start_slot) {
      if (cell_of_corner[3 * start + start_slot] >= 0) continue;
      const int cell = cells.count();
      int vertex = start, slot = start_slot;
      do {
        // If a corner other than the first is visited twice, the step to the next corner is not a permutation.
        if (cell_of_corner[3 * vertex + slot] >= 0) throw_invalid(vertex, "its cells do not close");
        cell_of_corner[3 * vertex + slot] = cell;
        cells.vertices.push_back(vertex);
        const int next = neighbours[vertex][slot];
        if (next < 0 || next >= count) throw_invalid(vertex, "neighbour " + std::to_string(next) + " is out of range");
        const int arrival = slot_of(neighbours, next, vertex);
        if (arrival < 0)
          throw_invalid(vertex, "neighbour " + std::to_string(next) + " does not list it as a neighbour");
        vertex = next;
        slot = previous_slot(arrival);
      } while (vertex != start || slot != start_slot);
      cells.offsets.push_back(static_cast<int>(cells.vertices.size()));
    }
  }
  return cells;
}

struct HalfEdge {
  int high, low_first, corner;  // larger end; 1 if the edge starts at its smaller end; 3 * triangle + side
};

/// Triangulation of the unit sphere and, for each triangle, the triangles across its sides. Side s runs from corner s
/// to corner s+1.
struct UnitSphere {
  std::vector<Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 3>> across;
};

UnitSphere make_icosahedron() {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  UnitSphere s;
  s.points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
              {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (auto& p : s.points) p.normalize();
  s.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  TriangleMesh t;
  for (const auto& p : s.points) t.positions.push_back(p.cast<float>());
  t.triangles = s.triangles;
  s.across = dual_of(t).neighbours;
  return s;
}

/// Subdivides each triangle t into 4t + s (corner s and the midpoints of sides s and s-1) and 4t + 3 (the midpoints).
/// The four triangles are contiguous at every level, and their adjacency follows from the coarse one without a search.
UnitSphere subdivide(const UnitSphere& coarse) {
  const int count = static_cast<int>(coarse.triangles.size());
  UnitSphere fine;
  fine.points = coarse.points;
  fine.points.reserve(coarse.points.size() + 3 * static_cast<std::size_t>(count) / 2);
  fine.triangles.resize(4 * static_cast<std::size_t>(count));
  fine.across.resize(4 * static_cast<std::size_t>(count));
  std::vector<std::array<int, 3>> middle(count);
  for (int t = 0; t < count; ++t) {
    const auto& corner = coarse.triangles[t];
    std::array<int, 3> other_side;
    for (int s = 0; s < 3; ++s) {
      const int u = coarse.across[t][s];
      other_side[s] = slot_of(coarse.across, u, t);
      if (u < t) {
        middle[t][s] = middle[u][other_side[s]];
      } else {
        middle[t][s] = static_cast<int>(fine.points.size());
        fine.points.push_back((coarse.points[corner[s]] + coarse.points[corner[next_slot(s)]]).normalized());
      }
    }
    for (int s = 0; s < 3; ++s) {
      const int before = previous_slot(s);
      fine.triangles[4 * t + s] = {corner[s], middle[t][s], middle[t][before]};
      // Side s of t is side o of u run backwards: corner s of t meets corner o+1 of u there.
      fine.across[4 * t + s] = {4 * coarse.across[t][s] + next_slot(other_side[s]), 4 * t + 3,
                                4 * coarse.across[t][before] + other_side[before]};
    }
    fine.triangles[4 * t + 3] = middle[t];
    fine.across[4 * t + 3] = {4 * t + 1, 4 * t + 2, 4 * t};
  }
  return fine;
}

/// Normal at P of the sphere through P and its neighbours, whose curvature is the vertex's sin(phi)/r. It is exact on a
/// sphere for any distribution of the neighbours, whereas (P2-P1)x(P3-P1) tilts by O(edge). With q_k = P_k - P,
/// n.q_k = -|q_k|^2/(2R) gives n ~ sum |q_1|^2 q_2 x q_3 (cyclic), which also holds in the flat limit R -> infinity.
Vector3d sphere_normal(const SimplexMesh& mesh, int vertex) {
  const Vector3d p = position_of(mesh, vertex);
  const auto& n = mesh.neighbours[vertex];
  const Vector3d q1 = position_of(mesh, n[0]) - p, q2 = position_of(mesh, n[1]) - p, q3 = position_of(mesh, n[2]) - p;
  const Vector3d c12 = q1.cross(q2), c23 = q2.cross(q3), c31 = q3.cross(q1);
  const Vector3d on_sphere = q1.squaredNorm() * c23 + q2.squaredNorm() * c31 + q3.squaredNorm() * c12;
  const Vector3d simplex = c12 + c23 + c31;
  const double bound = on_sphere.norm() * simplex.norm();
  // If P lies outside the circumcircle of its neighbours, the sphere does not approximate the surface.
  if (bound > 0.0 && on_sphere.dot(simplex) > 0.5 * bound) return on_sphere.normalized();
  return vertex_geometry(mesh, vertex).normal;
}

/// Value x / (1 + sqrt(1 - y)) for y in [0, 1]; a y that rounding has raised above 1 counts as 1.
double over_root(double x, double y) { return x / (1.0 + std::sqrt(std::max(0.0, 1.0 - y))); }

}  // namespace

CellList cells_of(const SimplexMesh& mesh) {
  SIMPLEXSEG_EXPECT(mesh.neighbours.size() == mesh.positions.size());
  std::vector<int> cell_of_corner;
  return trace_cells(mesh, cell_of_corner);
}

void validate(const SimplexMesh& mesh) {
  const std::size_t size = mesh.positions.size();
  if (size < 4 || size % 2 != 0)
    throw Error("simplex mesh of " + std::to_string(size) + " vertices", "the count must be even and at least 4",
                "give every vertex exactly three neighbours on a closed surface");
  if (mesh.neighbours.size() != size)
    throw Error("simplex mesh of " + std::to_string(size) + " vertices",
                "it has neighbours for " + std::to_string(mesh.neighbours.size()) + " vertices",
                "give one triple for each vertex");
  const int count = mesh.vertex_count();
  for (int v = 0; v < count; ++v) {
    if (!mesh.positions[v].allFinite()) throw_invalid(v, "its position is not finite");
    const auto& n = mesh.neighbours[v];
    for (int w : n) {
      if (w < 0 || w >= count) throw_invalid(v, "neighbour " + std::to_string(w) + " is out of range");
      if (w == v) throw_invalid(v, "it is its own neighbour");
      if (slot_of(mesh.neighbours, w, v) < 0)
        throw_invalid(v, "neighbour " + std::to_string(w) + " does not list it as a neighbour");
    }
    if (n[0] == n[1] || n[1] == n[2] || n[2] == n[0]) throw_invalid(v, "it lists a neighbour twice");
  }
  // Mutual, distinct neighbours in cyclic order form a rotation system, whose cells make up a closed oriented surface:
  // V - E + F = 2 - 2g then holds for each connected part. At a vertex whose neighbours are in reverse order, the three
  // cells merge into one, which visits the vertex more than once.
  const CellList cells = cells_of(mesh);
  std::vector<int> last_cell(count, -1);
  for (int c = 0; c < cells.count(); ++c) {
    for (int v : cells[c]) {
      if (last_cell[v] == c) throw_invalid(v, "a cell visits it twice, so its neighbours are not counter-clockwise");
      last_cell[v] = c;
    }
  }
  const double volume_mm3 = measure(mesh).volume_mm3;
  if (!(volume_mm3 > 0.0))
    throw Error("simplex mesh with a volume of " + volume_text(volume_mm3),
                "its neighbours are not counter-clockwise seen from outside", "swap two neighbours of every vertex");
}

SimplexMesh dual_of(const TriangleMesh& triangulation) {
  const char* remedy = "give a closed, consistently oriented 2-manifold triangulation";
  const auto& triangles = triangulation.triangles;
  const int point_count = static_cast<int>(triangulation.positions.size());
  const int count = static_cast<int>(triangles.size());
  if (count == 0) throw Error("triangulation", "it has no triangles", remedy);

  // Sorts the sides by their smaller end (counting sort), then pairs the few sides of each bucket.
  std::vector<int> offsets(point_count + 1, 0);
  for (int t = 0; t < count; ++t) {
    const auto& corner = triangles[t];
    for (int point : corner)
      if (point < 0 || point >= point_count)
        throw Error("triangle " + std::to_string(t), "point " + std::to_string(point) + " is out of range", remedy);
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])
      throw Error("triangle " + std::to_string(t), "it contains a point twice", remedy);
    for (int s = 0; s < 3; ++s) ++offsets[std::min(corner[s], corner[next_slot(s)]) + 1];
  }
  for (int p = 0; p < point_count; ++p) offsets[p + 1] += offsets[p];
  std::vector<HalfEdge> sides(3 * static_cast<std::size_t>(count));
  std::vector<int> cursor(offsets.begin(), offsets.end() - 1);
  for (int t = 0; t < count; ++t) {
    for (int s = 0; s < 3; ++s) {
      const int from = triangles[t][s], to = triangles[t][next_slot(s)];
      sides[cursor[std::min(from, to)]++] = {std::max(from, to), from < to, 3 * t + s};
    }
  }
  SimplexMesh mesh;
  mesh.positions.resize(count);
  mesh.neighbours.resize(count);
  for (int low = 0; low < point_count; ++low) {
    const auto begin = sides.begin() + offsets[low], end = sides.begin() + offsets[low + 1];
    std::sort(begin, end, [](const HalfEdge& a, const HalfEdge& b) {
      return a.high != b.high ? a.high < b.high : a.corner < b.corner;
    });
    for (auto first = begin; first != end;) {
      auto last = first;
      while (last != end && last->high == first->high) ++last;
      if (last - first != 2)
        throw Error("edge " + edge_name(low, first->high),
                    "it has " + counted(last - first, "triangle") + " where a closed surface has two", remedy);
      const HalfEdge& a = first[0];
      const HalfEdge& b = first[1];
      if (a.low_first == b.low_first)
        throw Error("edge " + edge_name(low, a.high), "its two triangles have opposite orientations", remedy);
      mesh.neighbours[a.corner / 3][a.corner % 3] = b.corner / 3;
      mesh.neighbours[b.corner / 3][b.corner % 3] = a.corner / 3;
      first = last;
    }
  }
  for (int t = 0; t < count; ++t) {
    const auto& n = mesh.neighbours[t];
    if (n[0] == n[1] || n[1] == n[2] || n[2] == n[0])
      throw Error("triangle " + std::to_string(t), "it shares two edges with another triangle", remedy);
    Vector3d sum = Vector3d::Zero();
    for (int point : triangles[t]) sum += triangulation.positions[point].cast<double>();
    mesh.positions[t] = (sum / 3.0).cast<float>();
  }
  return mesh;
}

SimplexMesh make_sphere(const Vector3d& centre_mm, double radius_mm, int level) {
  return make_ellipsoid(centre_mm, Vector3d::Constant(radius_mm), level);
}

SimplexMesh make_ellipsoid(const Vector3d& centre_mm, const Vector3d& radii_mm, int level) {
  if (level < 0 || level > kMaxSphereLevel)
    throw Error("sphere level " + std::to_string(level), "out of range",
                "choose a level from 0 to " + std::to_string(kMaxSphereLevel));
  if (!centre_mm.allFinite()) throw Error("sphere centre", "it is not finite", "give three finite coordinates in mm");
  if (!radii_mm.allFinite() || radii_mm.minCoeff() <= 0.0)
    throw Error("sphere radius " + length_text(radii_mm.minCoeff()), "it is not positive and finite",
                "give the radius in mm");
  UnitSphere sphere = make_icosahedron();
  for (int k = 0; k < level; ++k) sphere = subdivide(sphere);
  SimplexMesh mesh;
  mesh.positions.resize(sphere.triangles.size());
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    const auto& corner = sphere.triangles[t];
    const Vector3d direction =
        (sphere.points[corner[0]] + sphere.points[corner[1]] + sphere.points[corner[2]]).normalized();
    mesh.positions[t] = (centre_mm + radii_mm.cwiseProduct(direction)).cast<float>();
  }
  mesh.neighbours = std::move(sphere.across);
  return mesh;
}

int sphere_level_for(int vertices) {
  int level = 0;
  for (long long count = 20; count < vertices; count *= 4) ++level;
  return level;
}

Refined refine(const SimplexMesh& mesh) {
  const int count = mesh.vertex_count();
  if (count > kMaxRefinedVertices)
    throw Error("refinement of " + std::to_string(count) + " vertices", "the result would be too large",
                "refine a coarser mesh");
  std::vector<int> cell_of_corner;
  const CellList cells = trace_cells(mesh, cell_of_corner);
  std::vector<Vector3d> normals(count);
  for (int v = 0; v < count; ++v) normals[v] = sphere_normal(mesh, v);

  // New points are lifted as on a sphere of radius R, where both formulas are exact up to rounding.
  // The normals give 1/R:
  // 1. The centre C of points w_k on the sphere has |C|^2 = R^2 - s, s = mean |w_k - C|^2, and
  //    m = mean (w_k - C).n_k = s/R. It lies R - |C| = m / (1 + sqrt(1 - m^2/s)) below the sphere.
  // 2. The middle of a chord d has g = d.(n_b - n_a) = d^2/R and lies R - sqrt(R^2 - d^2/4) below the sphere,
  //    = g/4 / (1 + sqrt(1 - g^2/(4 d^2))).
  std::vector<Vector3d> centres(cells.count()), centre_normals(cells.count());
  for (int c = 0; c < cells.count(); ++c) {
    Vector3d centre = Vector3d::Zero(), normal = Vector3d::Zero();
    for (int v : cells[c]) {
      centre += position_of(mesh, v);
      normal += normals[v];
    }
    const double size = static_cast<double>(cells[c].size());
    centre /= size;
    normal.normalize();  // leaves a zero vector unchanged, so that the centre is not lifted
    double square = 0.0, slope = 0.0;
    for (int v : cells[c]) {
      const Vector3d arm = position_of(mesh, v) - centre;
      square += arm.squaredNorm() / size;
      slope += arm.dot(normals[v]) / size;
    }
    if (square > 0.0) centre += over_root(slope, slope * slope / square) * normal;
    centres[c] = centre;
    centre_normals[c] = normal;
  }

  Refined fine;
  fine.mesh.positions.resize(4 * static_cast<std::size_t>(count));
  fine.mesh.neighbours.resize(4 * static_cast<std::size_t>(count));
  fine.parent.resize(4 * static_cast<std::size_t>(count));
  const auto corner_index = [count](int vertex, int slot) { return count + 3 * vertex + slot; };
  for (int v = 0; v < count; ++v) {
    fine.mesh.positions[v] = mesh.positions[v];
    fine.mesh.neighbours[v] = {corner_index(v, 0), corner_index(v, 1), corner_index(v, 2)};
    fine.parent[v] = v;
    const Vector3d p = position_of(mesh, v);
    for (int s = 0; s < 3; ++s) {
      const int corner = corner_index(v, s);
      const int cell = cell_of_corner[3 * v + s];
      const Vector3d chord = centres[cell] - p;
      const double turn = chord.dot(centre_normals[cell] - normals[v]), square = chord.squaredNorm();
      Vector3d point = 0.5 * (p + centres[cell]);
      if (square > 0.0)
        point += over_root(0.25 * turn, 0.25 * turn * turn / square) * (normals[v] + centre_normals[cell]).normalized();
      fine.mesh.positions[corner] = point.cast<float>();
      fine.parent[corner] = v;
      // Neighbours of a corner point: the coarse vertex, then the next and the previous corner of its cell.
      const int next = mesh.neighbours[v][s], previous = mesh.neighbours[v][next_slot(s)];
      fine.mesh.neighbours[corner] = {v, corner_index(next, previous_slot(slot_of(mesh.neighbours, next, v))),
                                      corner_index(previous, slot_of(mesh.neighbours, previous, v))};
    }
  }
  return fine;
}

Neighbourhood neighbourhood_of(const SimplexMesh& mesh, int vertex, int order) {
  if (vertex < 0 || vertex >= mesh.vertex_count())
    throw Error("vertex " + std::to_string(vertex), "out of range",
                "choose one of the " + std::to_string(mesh.vertex_count()) + " vertices of the mesh");
  if (order < 0) throw Error("neighbourhood order " + std::to_string(order), "it is negative", "choose 0 or more");
  Neighbourhood result{{vertex}, {0}};
  std::unordered_set<int> seen{vertex};
  for (std::size_t i = 0; i < result.vertices.size() && result.ring[i] < order; ++i) {
    for (int w : mesh.neighbours[result.vertices[i]]) {
      if (!seen.insert(w).second) continue;
      result.vertices.push_back(w);
      result.ring.push_back(result.ring[i] + 1);
    }
  }
  return result;
}

}  // namespace simplexseg
