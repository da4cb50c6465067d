// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec3.h"
#include "field/run_jobs.h"
#include "image/distance_map.h"
#include "image/volume.h"

namespace simplexseg {

/// Smallest difference between the probability of a cell and 0.5. Keeps the surface away from the centres of cells.
inline constexpr float kThresholdMargin = 0.05f;

/// What the field of a mesh keeps of a voxel (FieldBox in src/forces/step_view.h): P(object), brought onto the
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

/// The value of each voxel of a box, of its object and its P(object).
std::vector<std::uint16_t> field_values(const std::vector<std::uint8_t>& object, std::span<const float> probability,
                                        const VoxelBox& box, const VolumeGeometry& geometry, const FieldValue& value,
                                        const RunJobs& run);

}  // namespace simplexseg
