// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_field.h"

#include "forces/step_view.h"

namespace simplexseg {

std::vector<std::uint8_t> MeshField::object_cells() const {
  std::vector<std::uint8_t> object(values.size());
  for (std::size_t v = 0; v < object.size(); ++v) object[v] = static_cast<float>(values[v]) > 0.5f * kFieldScale;
  return object;
}

Mask MeshField::object(const VolumeGeometry& volume) const {
  if (cell == kVoxelCells) return mask_of(volume, box, object_cells());
  return mask_above(volume, cell, box, values, 0.5f * kFieldScale);
}

VolumeGeometry MeshField::grid(const VolumeGeometry& volume) const {
  VolumeGeometry grid = cell_geometry(volume, cell);
  grid.origin_mm = grid.world_from_index() * Eigen::Vector3i(box.first.data()).cast<double>();
  grid.size = box.size;
  grid.header = nullptr;
  return grid;
}

}  // namespace simplexseg
