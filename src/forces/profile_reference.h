// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "forces/parameters.h"
#include "image/volume.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Samples of a reference profile: 2 * half + 1, at distances of `step_mm`.
struct ProfileSamples {
  int half = 0;
  double step_mm = 0;
};
/// Samples for the half_length and spacing of the intensity profile force. The volume must not be empty.
ProfileSamples profile_samples_of(const ForceParameters& forces, const Volume& volume);

/// Reference profiles of the intensity profile force: intensities along the normal of each vertex of the current pose,
/// from inside to outside, with the samples of profile_samples_of(). The volume must not be empty.
std::vector<float> profile_reference_of(const SimplexMesh& mesh, const Volume& volume, const ForceParameters& forces);

}  // namespace simplexseg
