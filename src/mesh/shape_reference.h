// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "core/vec3.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Shape memory's reference of a pose: (e1, e2, h_mm, S_mm2) of each vertex. Metric parameters with sum |e_k| > 5 (feet
/// far outside of their triangle: needles) are moved towards 1/3 until the sum is 5, so that the stability bound stays
/// finite.
std::vector<Vec4> shape_reference_of(const SimplexMesh& mesh);

}  // namespace simplexseg
