// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "field/evidence_settings.h"
#include "field/marked_voxels.h"

namespace simplexseg {

/// Radius in mm for the mark of a click: large where the click is far from the object's surface, as a user clicks in
/// the middle of what is wrong, but no nearer than half way to what is known to be on the other side; the sides of the
/// box count as outside. A click in a thin layer beside the surface gets a mark that does not reach through it.
/// `object` (0 or 1) and `known` are of the voxels of `box`. The least radius for a boundary mark.
double brush_radius_mm(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> object,
                       std::span<const Constraint> known, MarkKind kind, const Eigen::Vector3d& position_mm,
                       const EvidenceSettings& settings = {});
/// The same where there is no field yet.
double least_brush_radius_mm(const VolumeGeometry& geometry, const EvidenceSettings& settings = {});

}  // namespace simplexseg
