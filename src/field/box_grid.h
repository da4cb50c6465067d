// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "core/vec3.h"

namespace simplexseg {

/// Grid of the cells of a box, i fastest: number of cells, and strides of an array with a value for each.
struct BoxGrid {
  std::array<int, 3> size{0, 0, 0};
  SIMPLEXSEG_HD int count() const { return size[0] * size[1] * size[2]; }
  SIMPLEXSEG_HD int row() const { return size[0]; }
  SIMPLEXSEG_HD int plane() const { return size[0] * size[1]; }
  SIMPLEXSEG_HD int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? row() : plane(); }
};

}  // namespace simplexseg
