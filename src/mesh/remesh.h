// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// The same surface with edges of about `edge_mm` and about six triangles around each vertex, so that its dual has even
/// cells: long edges are split, short ones contracted, the others turned where that evens out the valences, and
/// vertices drawn to the middle of their neighbours within their tangent plane (Botsch and Kobbelt 2004, A remeshing
/// approach to multiresolution modeling). Topology is kept: an edge is contracted only where its ends have no
/// neighbours in common but the two across it (the link condition of Dey et al. 1999), and nothing is done that would
/// turn a triangle over or leave fewer than four triangles around a vertex. `surface` is closed and oriented; parts too
/// small for the edge keep as many triangles as their topology needs. `onto`: where a place near the surface is to lie
/// (mm), for vertices leave it when edges are contracted.
using OntoSurface = std::function<Eigen::Vector3d(const Eigen::Vector3d& mm)>;
TriangleMesh remesh(const TriangleMesh& surface, double edge_mm, const OntoSurface& onto);

/// The dual of remesh(), each of its vertices brought onto the surface.
SimplexMesh even_dual_of(const TriangleMesh& surface, double edge_mm, const OntoSurface& onto);
/// The edge that a surface of so many even triangles has, each of which has sqrt(3)/4 of its edge squared.
double even_edge_mm(const TriangleMesh& surface, double triangles);

/// The area of all triangles, in mm2.
double area_mm2(const TriangleMesh& surface);

}  // namespace simplexseg
