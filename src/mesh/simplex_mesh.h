// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Closed triangulation, for example the tessellation of a simplex mesh or the triangulation to which it is dual.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> positions;     ///< mm, LPS
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// 2-simplex mesh (Delingette 1999): every vertex has exactly three neighbours, counter-clockwise seen from outside.
/// Cells, normals and areas are computed when required, not stored (docs/mathematics.md, section 1).
struct SimplexMesh {
  std::vector<Eigen::Vector3f> positions;      ///< mm, LPS
  std::vector<std::array<int, 3>> neighbours;  ///< three neighbours of each vertex

  int vertex_count() const { return static_cast<int>(positions.size()); }
};
/// Position of a vertex in double precision, mm.
inline Eigen::Vector3d position_of(const SimplexMesh& mesh, int vertex) {
  return mesh.positions[static_cast<std::size_t>(vertex)].cast<double>();
}

/// Polygonal cells of a mesh: cell c has vertices[offsets[c] .. offsets[c+1]), counter-clockwise seen from outside.
/// Cells start with their smallest vertex and are ordered by it; ties are ordered by the neighbour slot of this vertex.
struct CellList {
  std::vector<int> offsets{0};
  std::vector<int> vertices;
  int count() const { return static_cast<int>(offsets.size()) - 1; }
  std::span<const int> operator[](int c) const {
    return {vertices.data() + offsets[c], std::size_t(offsets[c + 1] - offsets[c])};
  }
};

/// Traces the cells in the rotation system of the neighbours: F = V/2 + 2 - 2g cells for a connected mesh of genus g.
/// Throws Error if the neighbours are not consistent.
CellList cells_of(const SimplexMesh& mesh);

/// Checks the invariants. Throws Error, with the first offending vertex if any. V is even and >= 4; there are as many
/// neighbour triples as positions; positions are finite; the three neighbours are distinct, mutual, in range and not
/// the vertex itself; every cell has 3 or more vertices and contains none twice; V - E + F is even and at most 2 for
/// each connected part (orientable, closed); the volume is positive (oriented outwards).
void validate(const SimplexMesh& mesh);

/// Dual of a closed, oriented 2-manifold triangulation: vertex = triangle centroid, neighbours = the three
/// edge-adjacent triangles. Throws Error if there are no triangles, if a triangle has an invalid or repeated point or
/// shares two edges with another, or if an edge does not have exactly two consistently oriented triangles.
SimplexMesh dual_of(const TriangleMesh& triangulation);

/// Dual of an icosahedron subdivided `level` times, with V = 20 * 4^level vertices (20, 80, 320, 1280, 5120, 20480,
/// 81920 ...) at the distance `radius_mm` from the centre, up to rounding. Throws Error unless `level` is from 0 to 11,
/// the centre is finite and the radius is finite and > 0.
SimplexMesh make_sphere(const Eigen::Vector3d& centre_mm, double radius_mm, int level);
/// Ellipsoid with its axes along x, y, z: the sphere of radius 1 scaled by `radii_mm`. Errors as for make_sphere().
SimplexMesh make_ellipsoid(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& radii_mm, int level);
/// Smallest level whose sphere has at least `vertices` vertices.
int sphere_level_for(int vertices);

/// Refined mesh. parent[v]: coarse vertex at whose cell corner vertex v was added; v itself for a coarse vertex.
struct Refined {
  SimplexMesh mesh;
  std::vector<int> parent;
};
/// Refines a mesh fourfold: coarse vertices keep index and position, a vertex near (P + C_c)/2 is added for each cell
/// corner and a hexagon for each coarse edge, so V' = 4V and F' = F + 3V/2. New vertices are lifted along the normal so
/// that the curvature is preserved. Throws Error for more than 2^27 coarse vertices.
Refined refine(const SimplexMesh& mesh);

/// Vertices around a vertex in breadth-first order, ring by ring. Ring 0 is the vertex itself.
struct Neighbourhood {
  std::vector<int> vertices;
  std::vector<int> ring;  ///< ring of each entry of `vertices`
};
/// Neighbourhood of `vertex` up to ring `order`. Throws Error if either is out of range.
Neighbourhood neighbourhood_of(const SimplexMesh& mesh, int vertex, int order);

}  // namespace simplexseg
