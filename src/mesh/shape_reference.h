// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "core/vec3.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Reference pose for the shape memory force: (e1, e2, h_mm, S_mm2) of each vertex. Metric parameters with
/// sum |e_k| > 5 (needle triangles whose foot lies far outside) are moved towards 1/3 until the sum is 5, which keeps
/// the stability bound finite.
std::vector<Vec4> shape_reference_of(const SimplexMesh& mesh);

}  // namespace simplexseg
