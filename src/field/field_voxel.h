// SPDX-License-Identifier: Apache-2.0
// Stored forms of a field, and its values at the edge of the volume.
#pragma once
#include <cmath>
#include <cstdint>

#include "core/vec3.h"

namespace simplexseg {

/// Foreground probability as stored for the previous field: 1..255 for 0..1; 0 is unknown.
SIMPLEXSEG_HD std::uint8_t to_8_bits(float probability) { return static_cast<std::uint8_t>(1.5f + 254 * probability); }

/// Solution as stored between updates, the start of the next one: 0..65535 for 0..1.
SIMPLEXSEG_HD std::uint16_t to_16_bits(float probability) {
  return static_cast<std::uint16_t>(0.5f + 65535 * smaller(larger(probability, 0.0f), 1.0f));
}
SIMPLEXSEG_HD float from_16_bits(std::uint16_t solution) { return static_cast<float>(solution) * (1.0f / 65535); }

/// Intensity difference of neighbours at which conductances of sharpness `beta` are exp(-1/2).
inline float edge_difference(double beta) { return static_cast<float>(1 / std::sqrt(2 * beta)); }

/// Field of the next voxel inward from a voxel at the edge of the volume, so that an object that is cut by the volume
/// extends to the edge.
struct InwardValue {
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
