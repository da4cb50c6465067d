// SPDX-License-Identifier: Apache-2.0
#include "forces/profile_reference.h"

#include "forces/force_list.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {

std::vector<float> profile_reference_of(const SimplexMesh& mesh, const Volume& volume, const ForceParameters& forces) {
  const float* p = forces.values[static_cast<int>(ForceId::IntensityProfile)];
  const int half = static_cast<int>(p[IntensityProfileForce::half_length] + 0.5f);
  const double step = p[IntensityProfileForce::spacing] * volume.geometry().spacing_mm.minCoeff();
  std::vector<float> profiles;
  profiles.reserve(mesh.positions.size() * (2 * half + 1));
  for (int i = 0; i < mesh.vertex_count(); ++i) {
    const Eigen::Vector3d normal = vertex_geometry(mesh, i).normal;
    for (int k = -half; k <= half; ++k)
      profiles.push_back(static_cast<float>(volume.sample(mesh.positions[i].cast<double>() + k * step * normal)));
  }
  return profiles;
}

}  // namespace simplexseg
