// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "core/vec3.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Reference pose for the shape memory force: (e1, e2, h (mm), S (mm^2)) of each vertex (VertexGeometry). Metric
/// parameters with sum |e_k| > 5 (needle triangles whose foot lies far outside) are moved towards 1/3 until the sum is
/// at most 5, which limits the stability bound to 6.
std::vector<Vec4> shape_reference_of(const SimplexMesh& mesh);

}  // namespace simplexseg
