// SPDX-License-Identifier: Apache-2.0
#include "field/brush_radius.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"

namespace simplexseg {

double brush_radius_mm(const VolumeGeometry& cells, const VoxelBox& box, std::span<const std::uint8_t> object,
                       MarkKind kind, const Eigen::Vector3d& position_mm, const EvidenceSettings& settings) {
  SIMPLEXSEG_EXPECT(object.size() == box.voxel_count());
  const double radius = far_brush_radius_mm(cells, settings);
  if (kind == MarkKind::Boundary) return radius;
  // Cells within `radius` of the place.
  const Eigen::Affine3d world = cells.world_from_index(), index = world.inverse();
  const Eigen::Vector3d centre = index * position_mm;
  std::array<int, 3> first, last;
  for (int a = 0; a < 3; ++a) {
    const double reach = radius * index.linear().row(a).norm(), from = centre[a] - box.first[a];
    first[a] = static_cast<int>(std::clamp(std::ceil(from - reach), 0.0, static_cast<double>(box.size[a])));
    last[a] = static_cast<int>(std::clamp(std::floor(from + reach), -1.0, box.size[a] - 1.0));
  }
  double nearest = radius * radius;  // squared distance of the nearest cell on the other side of the surface, mm^2
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        if ((object[box.offset(i, j, k)] != 0) != (kind == MarkKind::Inside)) continue;
        const Eigen::Vector3d at(i + box.first[0], j + box.first[1], k + box.first[2]);
        nearest = std::min(nearest, (world * at - position_mm).squaredNorm());
      }
  return std::max(std::sqrt(nearest), std::min(settings.smallest_brush * cells.spacing_mm.minCoeff(), radius));
}

double far_brush_radius_mm(const VolumeGeometry& geometry, const EvidenceSettings& settings) {
  return settings.brush * geometry.spacing_mm.minCoeff();
}

}  // namespace simplexseg
