// SPDX-License-Identifier: Apache-2.0
#include "field/field_value.h"

namespace simplexseg {

std::vector<std::uint16_t> field_values(const std::vector<std::uint8_t>& object, std::span<const float> probability,
                                        const VoxelBox& box, const VolumeGeometry& geometry, const FieldValue& value,
                                        const RunJobs& run) {
  const std::vector<float> distance_mm = distance_map(object, box, geometry.world_from_index().linear());
  std::vector<std::uint16_t> values(object.size());
  for_each_index(run, static_cast<int>(values.size()),
                 [&, p = probability.data()](int v) { values[v] = value(object[v] != 0, p[v], distance_mm[v]); });
  return values;
}

}  // namespace simplexseg
