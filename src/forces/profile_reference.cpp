// SPDX-License-Identifier: Apache-2.0
#include "forces/profile_reference.h"

#include "forces/force_list.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {

ProfileSamples profile_samples_of(const ForceParameters& forces, const Volume& volume) {
  using F = IntensityProfileForce;
  const float spacing = forces.values[static_cast<int>(F::id)][F::spacing];
  return {forces.integer(F::id, F::half_length), spacing * volume.geometry().spacing_mm.minCoeff()};
}

std::vector<float> profile_reference_of(const SimplexMesh& mesh, const Volume& volume, const ForceParameters& forces) {
  const auto [half, step_mm] = profile_samples_of(forces, volume);
  std::vector<float> profiles;
  profiles.reserve(mesh.positions.size() * (2 * half + 1));
  for (int i = 0; i < mesh.vertex_count(); ++i) {
    const Eigen::Vector3d normal = vertex_geometry(mesh, i).normal;
    for (int k = -half; k <= half; ++k)
      profiles.push_back(static_cast<float>(volume.sample(mesh.positions[i].cast<double>() + k * step_mm * normal)));
  }
  return profiles;
}

}  // namespace simplexseg
