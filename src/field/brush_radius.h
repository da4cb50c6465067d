// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "field/evidence_settings.h"
#include "field/marked_voxels.h"

namespace simplexseg {

/// Radius of the mark of a click, mm. It increases with the distance to the surface, since users click in the middle of
/// an error, and is at most half of the distance to the nearest constraint of the other kind; sides of the box are
/// outside. Near the surface it is at most that distance, so that the mark does not cross a thin error. Boundary marks
/// have least_brush_radius_mm(). `object` (0 or 1), `constraints`: a value for each voxel of `box`. Source:
/// docs/mathematics.md 8.8.
double brush_radius_mm(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> object,
                       std::span<const Constraint> constraints, MarkKind kind, const Eigen::Vector3d& position_mm,
                       const EvidenceSettings& settings = {});
/// Radius of the mark of a click without a field, mm.
double least_brush_radius_mm(const VolumeGeometry& geometry, const EvidenceSettings& settings = {});

}  // namespace simplexseg
