// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Projects a position (mm) near a surface onto the surface.
using SurfaceProjection = std::function<Eigen::Vector3d(const Eigen::Vector3d& mm)>;
/// Remeshes a closed, oriented surface to edges of about `edge_mm` and about six triangles around each vertex, so that
/// the cells of the dual mesh are regular. Long edges are split, short ones contracted and others flipped towards a
/// valence of six; then vertices move tangentially to the mean of their neighbours (Botsch and Kobbelt 2004, A
/// remeshing approach to multiresolution modeling). `project` moves vertices back onto the surface, since splits and
/// contractions move them off it.
///
/// The topology is preserved: an edge is contracted only if its ends share exactly the two neighbours across it (link
/// condition, Dey et al. 1999). No operation reverses a triangle or leaves fewer than four triangles around a vertex.
/// Parts that are too small for the edge length keep the triangles that their topology requires.
TriangleMesh remesh(const TriangleMesh& surface, double edge_mm, const SurfaceProjection& project);

/// Simplex mesh that is dual to the result of remesh(), with its vertices projected onto the surface.
SimplexMesh remeshed_dual_of(const TriangleMesh& surface, double edge_mm, const SurfaceProjection& project);
/// Edge length (mm) at which `triangles` equilateral triangles, of area sqrt(3)/4 edge^2 each, have the surface's area.
double equilateral_edge_mm(const TriangleMesh& surface, double triangles);

/// Sum of the areas of all triangles, mm^2.
double area_mm2(const TriangleMesh& surface);

}  // namespace simplexseg
