// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_field.h"

#include "forces/step_view.h"

namespace simplexseg {

std::vector<std::uint8_t> MeshField::object_voxels() const {
  std::vector<std::uint8_t> object(values.size());
  for (std::size_t v = 0; v < object.size(); ++v) object[v] = static_cast<float>(values[v]) > 0.5f * kFieldScale;
  return object;
}

}  // namespace simplexseg
