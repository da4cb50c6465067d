// SPDX-License-Identifier: Apache-2.0
// What is worked out for one voxel of a field, on whatever processor.
#pragma once
#include <cmath>
#include <cstdint>

#include "core/vec3.h"

namespace simplexseg {

/// P(object) as it is remembered: 1..255 for 0..1.
SIMPLEXSEG_HD std::uint8_t as_before(float probability) { return static_cast<std::uint8_t>(1.5f + 254 * probability); }

/// The solution as it is kept from one update to the next, which starts from it: 0..65535 for 0..1.
SIMPLEXSEG_HD std::uint16_t as_kept(float probability) {
  return static_cast<std::uint16_t>(0.5f + 65535 * smaller(larger(probability, 0.0f), 1.0f));
}
SIMPLEXSEG_HD float of_kept(std::uint16_t solution) { return static_cast<float>(solution) * (1.0f / 65535); }

/// A difference between neighbours that is an edge to conductances of this sharpness.
inline float edge_of(double beta) { return static_cast<float>(1 / std::sqrt(2 * beta)); }

/// For a voxel at the volume's side the field of the next one inward: an object that the volume cuts goes on to there.
struct FromInner {
  int size[3];  ///< of the box
  const float* field;

  SIMPLEXSEG_HD float operator()(int v) const {
    const int at[3]{v % size[0], v / size[0] % size[1], v / (size[0] * size[1])};
    const int stride[3]{1, size[0], size[0] * size[1]};
    int inner = v;
    for (int a = 0; a < 3; ++a) {
      if (size[a] < 3) continue;
      if (at[a] == 0) inner += stride[a];
      if (at[a] == size[a] - 1) inner -= stride[a];
    }
    return field[inner];
  }
};

}  // namespace simplexseg
