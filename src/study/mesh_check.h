// SPDX-License-Identifier: Apache-2.0
// Measures of a mesh that owe nothing to the engine's own, all in double.
#pragma once
#include "mesh/simplex_mesh.h"

namespace simplexseg {

bool all_finite(const SimplexMesh& mesh);
/// Vertices whose normal makes more than a right angle with that of a neighbour. `margin`: by how much the cosine is to
/// be below 0; vertices whose neighbours are nearly collinear have no normal and do not count.
int count_folds(const SimplexMesh& mesh, double margin = 0);
/// Whether the volume enclosed is below -`share` of that of a sphere of the same area.
bool is_inside_out(const SimplexMesh& mesh, double share);
double farthest_from(const SimplexMesh& mesh, const Eigen::Vector3d& centre_mm);
Eigen::Vector3d mean_position(const SimplexMesh& mesh);

}  // namespace simplexseg
