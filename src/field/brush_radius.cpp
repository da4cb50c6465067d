// SPDX-License-Identifier: Apache-2.0
#include "field/brush_radius.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/expect.h"

namespace simplexseg {

double brush_radius_mm(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> object,
                       std::span<const Constraint> constraints, MarkKind kind, const Eigen::Vector3d& position_mm,
                       const EvidenceSettings& settings) {
  SIMPLEXSEG_EXPECT(object.size() == box.voxel_count() && constraints.size() == box.voxel_count());
  const double far_radius = least_brush_radius_mm(geometry, settings);
  if (kind == MarkKind::Boundary) return far_radius;
  const Eigen::Affine3d world = geometry.world_from_index();
  const bool inside = kind == MarkKind::Inside;
  double surface = std::numeric_limits<double>::infinity(), mark = surface;  // squared distances, mm^2
  std::size_t v = 0;
  for (int k = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      for (int i = 0; i < box.size[0]; ++i, ++v) {
        const bool other_side = (object[v] != 0) == inside;
        const bool other_mark = inside ? is_dirichlet(constraints[v]) && constraints[v] != Constraint::Inside
                                       : constraints[v] == Constraint::Inside;
        if (!other_side && !other_mark) continue;
        const Eigen::Vector3d at(i + box.first[0], j + box.first[1], k + box.first[2]);
        const double d = (world * at - position_mm).squaredNorm();
        if (other_side) surface = std::min(surface, d);
        if (other_mark) mark = std::min(mark, d);
      }
    }
  }
  const double smallest = settings.smallest_brush * geometry.spacing_mm.minCoeff();
  const double least = std::clamp(std::sqrt(surface), std::min(smallest, far_radius), far_radius);
  const double radius = std::min(settings.brush * std::sqrt(surface), 0.5 * std::sqrt(mark));
  return std::isfinite(radius) ? std::max(least, radius) : least;
}

double least_brush_radius_mm(const VolumeGeometry& geometry, const EvidenceSettings& settings) {
  return settings.least_brush * geometry.spacing_mm.minCoeff();
}

}  // namespace simplexseg
