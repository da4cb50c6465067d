// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "forces/parameters.h"
#include "image/volume.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Reference profiles of the intensity profile force: intensities along the normal of each vertex of the current pose,
/// from inside to outside, 2 * half_length + 1 values per vertex. `forces` contains half_length and the spacing of the
/// samples. The volume must not be empty.
std::vector<float> profile_reference_of(const SimplexMesh& mesh, const Volume& volume, const ForceParameters& forces);

}  // namespace simplexseg
