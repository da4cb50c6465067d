// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "core/vec3.h"

namespace simplexseg {

/// What the field of a mesh keeps of a voxel (field_values() in session/field_voxels.h): P(object), brought onto the
/// side of the middle that the voxel is on, and far from the object what tells how far.
struct FieldValue {
  float scale;        ///< of P = 1
  float floor, fall;  ///< at the object, and by how much it is less for each mm away from it
  float least_over;   ///< by how much a voxel is at least beyond the middle
  float near_mm;      ///< from the object, where P counts

  /// Beyond it a voxel's value is 0, mm.
  float farthest_mm() const { return floor / fall; }
  /// `distance_mm` to the object; of a voxel of the object it does not matter.
  SIMPLEXSEG_HD std::uint16_t operator()(bool object, float p, float distance_mm) const {
    const float middle = 0.5f * scale, scaled = scale * p;
    const float far = larger(floor - fall * distance_mm, 0.0f);
    const float below = scaled < far ? far : middle - least_over < scaled ? middle - least_over : scaled;
    return static_cast<std::uint16_t>(object                  ? larger(scaled, middle + least_over)
                                      : distance_mm < near_mm ? below
                                                              : far);
  }
};

}  // namespace simplexseg
