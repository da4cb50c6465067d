// SPDX-License-Identifier: Apache-2.0
// Measurements of a mesh in double, independent of those of the engine.
#pragma once
#include "mesh/simplex_mesh.h"

namespace simplexseg {

bool all_finite(const SimplexMesh& mesh);
/// Number of vertices whose normal makes more than a right angle with the normal of a neighbour: the cosine is below
/// -`margin`. Vertices with nearly collinear neighbours have no normal and do not count.
int count_folds(const SimplexMesh& mesh, double margin = 0);
/// True if the enclosed volume is negative and its magnitude is more than `share` of the volume of a sphere of the same
/// area.
bool is_inverted(const SimplexMesh& mesh, double share);
/// Largest distance of a vertex from a point, mm.
double farthest_from(const SimplexMesh& mesh, const Eigen::Vector3d& centre_mm);
Eigen::Vector3d mean_position(const SimplexMesh& mesh);

}  // namespace simplexseg
