// SPDX-License-Identifier: Apache-2.0
#include "image/object_axes.h"

#include "mesh/plane_section.h"
#include "mesh/polygon_diameter.h"

namespace simplexseg {

std::optional<ObjectAxes> object_axes(const SimplexMesh& mesh, const VolumeGeometry& geometry) {
  if (mesh.positions.empty()) return std::nullopt;
  int axial = 2;
  geometry.direction.row(2).cwiseAbs().maxCoeff(&axial);
  // Index axes (u, v, k), of which k is the one across the slices.
  Eigen::Matrix3d order = Eigen::Matrix3d::Zero();
  order((axial + 1) % 3, 0) = order((axial + 2) % 3, 1) = order(axial, 2) = 1;
  const Eigen::Affine3d world_from_slice = geometry.world_from_index() * Eigen::Affine3d(order);
  // Orthonormal axes of the slices, since those of a sheared grid are oblique.
  const Eigen::Vector3d u = world_from_slice.linear().col(0), v = world_from_slice.linear().col(1);
  const Eigen::Vector3d right = u.normalized(), up = (v - v.dot(right) * right).normalized();
  Eigen::Matrix2d mm_from_index;
  mm_from_index << u.norm(), v.dot(right), 0, v.dot(up);

  Polygon longest;  // contour with the long axis, mm
  Chord long_axis;
  int slice = -1;
  const auto sections = plane_sections(mesh, world_from_slice.inverse(), geometry.size[axial]);
  for (std::size_t k = 0; k < sections.size(); ++k) {
    for (const Polygon& contour : sections[k]) {
      if (doubled_area(contour) <= 0) continue;  // a hole
      Polygon contour_mm;
      contour_mm.reserve(contour.size());
      for (const Eigen::Vector2d& corner : contour) contour_mm.emplace_back(mm_from_index * corner);
      const Chord chord = longest_chord(contour_mm);
      if (chord.length() <= long_axis.length()) continue;
      long_axis = chord, longest = std::move(contour_mm), slice = static_cast<int>(k);
    }
  }
  if (slice < 0) return std::nullopt;
  const Chord short_axis = longest_perpendicular_chord(longest, long_axis.to - long_axis.from);
  const auto world_of = [&](const Eigen::Vector2d& mm) -> Eigen::Vector3d {
    return world_from_slice * Eigen::Vector3d(0, 0, slice) + mm[0] * right + mm[1] * up;
  };
  const bool upwards = world_from_slice.linear()(2, 2) > 0;
  return ObjectAxes{{world_of(long_axis.from), world_of(long_axis.to)},
                    {world_of(short_axis.from), world_of(short_axis.to)},
                    upwards ? slice + 1 : geometry.size[axial] - slice};
}

}  // namespace simplexseg
