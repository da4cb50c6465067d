// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Closed triangulation: the dual of a simplex mesh, or its tessellation for drawing.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> positions;     ///< mm, LPS
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// 2-simplex mesh (Delingette 1999): every vertex has exactly three neighbours, counter-clockwise seen from outside.
/// Connectivity consists of indices. Cells, normals and areas are derived, not stored (docs/mathematics.md, section 1).
struct SimplexMesh {
  std::vector<Eigen::Vector3f> positions;      ///< mm, LPS
  std::vector<std::array<int, 3>> neighbours;  ///< three neighbours of each vertex

  int vertex_count() const { return static_cast<int>(positions.size()); }
};
/// Position of a vertex in double, mm.
inline Eigen::Vector3d position_of(const SimplexMesh& mesh, int vertex) {
  return mesh.positions[static_cast<std::size_t>(vertex)].cast<double>();
}

/// Polygonal cells of a mesh: cell c has vertices[offsets[c] .. offsets[c+1]), counter-clockwise seen from outside.
/// Cells are ordered by their smallest vertex (ties: by its neighbour slot) and start with it.
struct CellList {
  std::vector<int> offsets{0};
  std::vector<int> vertices;
  int count() const { return static_cast<int>(offsets.size()) - 1; }
  std::span<const int> operator[](int c) const {
    return {vertices.data() + offsets[c], std::size_t(offsets[c + 1] - offsets[c])};
  }
};

/// Cells traced in the rotation system of the neighbours; F = V/2 + 2 - 2g.
CellList cells_of(const SimplexMesh& mesh);

/// Checks the invariants; throws Error with the first vertex that violates one. V is even and >= 4; there are as many
/// neighbour triples as positions; positions are finite; the three neighbours are distinct, mutual, in range and not
/// the vertex itself; every cell has 3 or more vertices and contains none twice; V - E + F is even and at most 2 for
/// each connected part (orientable, closed); the volume is positive (oriented outwards).
void validate(const SimplexMesh& mesh);

/// Dual of a closed, oriented 2-manifold triangulation: vertex = triangle centroid, neighbours = the three
/// edge-adjacent triangles. Throws Error if an edge does not have exactly two consistently oriented triangles.
SimplexMesh dual_of(const TriangleMesh& triangulation);

/// Dual of an icosahedron subdivided `level` times, with V = 20 * 4^level vertices (20, 80, 320, 1280, 5120, 20480,
/// 81920 ...) at a distance of exactly `radius_mm` from the centre.
SimplexMesh make_sphere(const Eigen::Vector3d& centre_mm, double radius_mm, int level);
SimplexMesh make_ellipsoid(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& radii_mm, int level);
/// Smallest level whose sphere has at least `vertices` vertices.
int sphere_level_for(int vertices);

/// Refined mesh. parent[v]: coarse vertex at whose corner vertex v lies; v itself for a coarse vertex.
struct Refined {
  SimplexMesh mesh;
  std::vector<int> parent;
};
/// Refines a mesh fourfold: coarse vertices keep index and position, a vertex near (P + C_c)/2 is added for each cell
/// corner and a hexagon for each coarse edge, so V' = 4V and F' = F + 3V/2. New vertices are lifted along the normal so
/// that the curvature is preserved.
Refined refine(const SimplexMesh& mesh);

/// Vertices around `vertex` in breadth-first order, ring by ring up to `order` (ring 0 is the vertex itself).
struct Neighbourhood {
  std::vector<int> vertices;
  std::vector<int> ring;  ///< ring of each entry of `vertices`
};
Neighbourhood neighbourhood_of(const SimplexMesh& mesh, int vertex, int order);

}  // namespace simplexseg
