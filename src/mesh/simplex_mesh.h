// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// A closed triangulation: the dual of a simplex mesh, or what is drawn of one.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> positions;     ///< mm, LPS
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// A 2-simplex mesh (Delingette 1999): every vertex has exactly three neighbours, counter-clockwise seen from outside.
/// Indices, never pointers; cells, normals and areas are derived, not stored (docs/mathematics.md, section 1).
struct SimplexMesh {
  std::vector<Eigen::Vector3f> positions;      ///< mm, LPS
  std::vector<std::array<int, 3>> neighbours;  ///< three for each vertex

  int vertex_count() const { return static_cast<int>(positions.size()); }
};

/// The polygonal cells of a mesh: cell c has vertices[offsets[c] .. offsets[c+1]), counter-clockwise from outside.
/// Cells come in the order of their smallest vertex (ties: the order of the neighbour slot), and start with it.
struct CellList {
  std::vector<int> offsets{0};
  std::vector<int> vertices;
  int count() const { return static_cast<int>(offsets.size()) - 1; }
  std::span<const int> operator[](int c) const {
    return {vertices.data() + offsets[c], std::size_t(offsets[c + 1] - offsets[c])};
  }
};

/// The cells, found by walking the rotation system of the neighbours; F = V/2 + 2 - 2g.
CellList cells_of(const SimplexMesh& mesh);

/// Throws Error naming the first vertex that breaks an invariant: V even and >= 4, as many neighbours as positions,
/// finite positions, three distinct mutual neighbours in range and none itself, every cell of 3 or more vertices
/// visiting none twice, V - E + F even and at most 2 for each connected part (orientable, closed), and positive volume
/// (outward).
void validate(const SimplexMesh& mesh);

/// Dual of a closed, oriented 2-manifold triangulation: vertex = triangle centroid, neighbours = the three
/// edge-adjacent triangles. Throws Error when an edge has not exactly two triangles of opposite sense.
SimplexMesh dual_of(const TriangleMesh& triangulation);

/// Dual of an icosahedron subdivided `level` times (x4 each: V = 20 * 4^level) and put on the sphere:
/// V = 20, 80, 320, 1280, 5120, 20480, 81920 ... for level = 0, 1, 2, ...; vertices lie at `radius_mm` exactly.
SimplexMesh make_sphere(const Eigen::Vector3d& centre_mm, double radius_mm, int level);
SimplexMesh make_ellipsoid(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& radii_mm, int level);
/// The smallest level whose sphere has at least `vertices` vertices.
int sphere_level_for(int vertices);

/// x4 refinement: old vertices keep index and position, (P + C_c)/2 is added for each cell corner and one hexagon for
/// each old edge, so V' = 4V and F' = F + 3V/2. The new points are lifted along the normal so that curvature is kept.
/// `parent[v]` is the old vertex whose corner the new vertex v is (parent[v] == v for old ones).
struct Refined {
  SimplexMesh mesh;
  std::vector<int> parent;
};
Refined refine(const SimplexMesh& mesh);

/// The vertices around `vertex` in breadth-first order, ring by ring up to `order` (ring 0 is the vertex itself).
struct Neighbourhood {
  std::vector<int> vertices;
  std::vector<int> ring;  ///< one for each entry of vertices
};
Neighbourhood neighbourhood_of(const SimplexMesh& mesh, int vertex, int order);

}  // namespace simplexseg
