// SPDX-License-Identifier: Apache-2.0
// Geometry on the host, in double (docs/mathematics.md, section 1). The engine's float kernels are tested against
// these.
#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// For each cell edge (Pa, Pb) the triangle (C_c, Pa, Pb): 3V triangles over V + F points, the mesh's own vertices
/// first.
TriangleMesh tessellate(const SimplexMesh& mesh);

struct VertexGeometry {
  Eigen::Vector3d normal;   ///< unit, outward; a stable fallback where the neighbours are collinear, never NaN
  double elevation_mm;      ///< h = (P - P1).n, > 0 where convex
  Eigen::Vector3d metric;   ///< e1, e2, e3: barycentric coordinates of the foot F; sums to 1
  double doubled_area_mm2;  ///< S = |(P2-P1) x (P3-P1)|
  double mean_curvature;    ///< H = sin(phi)/r, 1/mm; > 0 where convex
};
VertexGeometry vertex_geometry(const SimplexMesh& mesh, int vertex);

struct SurfaceMeasures {
  double area_mm2;
  double volume_mm3;            ///< signed: > 0 when the orientation is outward
  Eigen::Vector3d centroid_mm;  ///< the enclosed solid's; the vertices' when the volume is 0
  double mean_edge_mm;
};
SurfaceMeasures measure(const SimplexMesh& mesh);
/// Mean length of the edges of a mesh, mm; 0 without vertices. `neighbours`: three of each vertex.
float mean_edge_mm(std::span<const Eigen::Vector3f> positions, std::span<const std::array<int, 3>> neighbours);
/// Half the summed area of the six triangles around each vertex, mm^2.
std::vector<double> vertex_areas(const SimplexMesh& mesh);

/// Vertices whose normal makes more than a right angle with that of a neighbour.
int folded_vertices(const SimplexMesh& mesh);

}  // namespace simplexseg
