// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <vector>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Positions of the vertices of a mesh as columns, mm.
Eigen::Matrix3Xd points_of(const SimplexMesh& mesh);
/// Mesh with the connectivity of `mesh` and its vertices at these points.
SimplexMesh mesh_at(const SimplexMesh& mesh, const Eigen::Matrix3Xd& points);
/// Unit normals of the vertices of a mesh at other positions, as columns (vertex_geometry()).
Eigen::Matrix3Xd normals_of(const std::vector<std::array<int, 3>>& neighbours, const Eigen::Matrix3Xd& points);

/// Registers a template mesh to a surface: positions (mm) of the vertices of the template on the surface, so that a
/// vertex is at the same place of the anatomy in every surface to which the template was registered. `surface`:
/// vertices and normals of a mesh of the object, of several times the density of the template.
///
/// Nonrigid iterative closest points: alternates between the nearest points with compatible normals, in both
/// directions, and the displacements d of the template in its similarity pose that minimise
///   sum_v w_v |y_v + d_v - q_v|^2 + stiffness sum_(u,v) |d_u - d_v|^2
/// for decreasing stiffness. Source: Amberg, Romdhani and Vetter 2007, Optimal step nonrigid ICP algorithms for surface
/// registration.
Eigen::Matrix3Xd register_template(const SimplexMesh& mesh, const SimplexMesh& surface);

}  // namespace simplexseg
