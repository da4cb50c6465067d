// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "field/field_value.h"
#include "field/parallel/distance.h"

namespace simplexseg {

/// field_values() (field/field_value.h) with arrays of an executor, for a volume with orthogonal axes. `squares`,
/// `scratch`: workspace of a float for each voxel. Four launches.
template <class Executor>
void field_values(const Executor& executor, const std::uint8_t* object, const float* probability, const BoxGrid& grid,
                  const std::array<double, 3>& spacing_mm, const FieldValue& value, float* squares, float* scratch,
                  std::uint16_t* values) {
  squared_distance_to_other_side(executor, object, grid, spacing_mm, value.farthest_mm(), false, squares, scratch);
  executor.each(grid.count(), [=] SIMPLEXSEG_KERNEL(int v) {
    values[v] = value(object[v] != 0, probability[v], std::sqrt(squares[v]));
  });
}

}  // namespace simplexseg
