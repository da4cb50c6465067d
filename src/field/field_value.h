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

/// Smallest difference between the probability of a cell and 0.5; keeps the surface away from the centres of cells.
inline constexpr float kThresholdMargin = 0.05f;

/// Value of a voxel in the field of a mesh (FieldBox in src/forces/step_view.h): foreground probability, bounded to the
/// side of the threshold on which the object mask has the voxel, and far from the object a function of the distance.
struct FieldValue {
  float scale;         ///< value of probability 1; the threshold is half of it
  float floor, slope;  ///< value of the distance 0, and decrease per mm
  float margin;        ///< least difference to the threshold
  float near_mm;       ///< distance from the object up to which the probability is stored

  /// Distance beyond which values are 0, mm.
  float farthest_mm() const { return floor / slope; }
  /// `distance_mm`: distance to the object; ignored in it.
  SIMPLEXSEG_HD std::uint16_t operator()(bool object, float p, float distance_mm) const {
    const float threshold = 0.5f * scale, scaled = scale * p;
    const float far = larger(floor - slope * distance_mm, 0.0f);
    const float below = scaled < far ? far : threshold - margin < scaled ? threshold - margin : scaled;
    return static_cast<std::uint16_t>(object                  ? larger(scaled, threshold + margin)
                                      : distance_mm < near_mm ? below
                                                              : far);
  }
};

/// Values of all voxels of a box from its object mask (0 or 1) and its foreground probability.
std::vector<std::uint16_t> field_values(const std::vector<std::uint8_t>& object, std::span<const float> probability,
                                        const VoxelBox& box, const VolumeGeometry& geometry, const FieldValue& value,
                                        const RunJobs& run);

}  // namespace simplexseg
