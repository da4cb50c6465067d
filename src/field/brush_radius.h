// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "field/evidence_settings.h"
#include "field/marked_voxels.h"

namespace simplexseg {

/// Radius of the mark of a click, mm: the distance to the surface, so that the mark does not cross a thin error, at
/// most far_brush_radius_mm() and at least `smallest_brush`. Boundary marks have far_brush_radius_mm(). `cells`:
/// grid of all cells of the volume; `object` (0 or 1): a value for each cell of `box`. Source: docs/mathematics.md 8.8.
double brush_radius_mm(const VolumeGeometry& cells, const VoxelBox& box, std::span<const std::uint8_t> object,
                       MarkKind kind, const Eigen::Vector3d& position_mm, const EvidenceSettings& settings = {});
/// Radius of the mark of a click far from the surface, or without a field, mm.
double far_brush_radius_mm(const VolumeGeometry& geometry, const EvidenceSettings& settings = {});

}  // namespace simplexseg
