// SPDX-License-Identifier: Apache-2.0
// Mesh geometry on the host in double precision (docs/mathematics.md, section 1), the reference for tests of the
// engine's float kernels.
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Triangulation with one triangle (C_c, Pa, Pb) for each edge (Pa, Pb) of each cell c, whose vertices have the mean
/// C_c: 3V triangles over V + F points, the vertices of the mesh first.
TriangleMesh tessellate(const SimplexMesh& mesh);

struct VertexGeometry {
  Eigen::Vector3d normal;   ///< unit normal, outward; orthogonal to the line of collinear neighbours, never NaN
  double elevation_mm;      ///< h = (P - P1).n, > 0 where convex
  Eigen::Vector3d metric;   ///< e1, e2, e3: barycentric coordinates of the foot F; their sum is 1
  double doubled_area_mm2;  ///< S = |(P2-P1) x (P3-P1)|
  double mean_curvature;    ///< H = sin(phi)/r, 1/mm; > 0 where convex
};
VertexGeometry vertex_geometry(const SimplexMesh& mesh, int vertex);

struct SurfaceMeasures {
  double area_mm2;
  double volume_mm3;            ///< enclosed volume; > 0 if the orientation is outward
  Eigen::Vector3d centroid_mm;  ///< centroid of the enclosed solid; mean of the vertices if the volume is 0
  double mean_edge_mm;
};
SurfaceMeasures measure(const SimplexMesh& mesh);
/// Mean edge length of a mesh, mm; 0 without vertices. `neighbours`: the three neighbours of each vertex.
float mean_edge_mm(std::span<const Eigen::Vector3f> positions, std::span<const std::array<int, 3>> neighbours);
/// Area of each vertex, mm^2: half the sum of the areas of the six tessellation triangles around it.
std::vector<double> vertex_areas(const SimplexMesh& mesh);

/// Number of folded vertices, whose normal makes more than a right angle with the normal of a neighbour.
int folded_vertices(const SimplexMesh& mesh);

}  // namespace simplexseg
