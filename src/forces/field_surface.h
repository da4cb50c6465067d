// SPDX-License-Identifier: Apache-2.0
// The surface of a mesh's field, seen from a vertex (docs/mathematics.md, section 2.5).
#pragma once
#include <cstdint>

#include "forces/sampling.h"

namespace simplexseg {

/// Gain of the evidence from a field: P >= (1 + 1/gain) / 2 is evidence 1 for the object.
inline constexpr float kFieldGain = 2;
/// Change of P per cell below which the field is flat and does not locate the surface.
inline constexpr float kFlatField = 0.02f;

/// Field of a mesh as a separate volume, in which the first cell of the box has index 0. Only the linear part of its
/// index_from_world is valid.
SIMPLEXSEG_HD VolumeView field_view(const StepView& v, const MeshConstants& m) {
  VolumeView view = v.volume;
  view.voxels = m.field.values;
  for (int a = 0; a < 3; ++a) {
    view.size[a] = m.field.size[a];
    for (int c = 0; c < 3; ++c) view.index_from_world[4 * a + c] *= m.field.scale[a];
  }
  return view;
}

/// Depth below which a sample without a value counts as outside the box, voxels (rounding).
inline constexpr float kFaceTolerance = 1e-3f;

/// Outer faces of the part of the volume that the box of a field covers, in indices of voxels.
struct CoveredBox {
  float low[3], high[3];
  SIMPLEXSEG_HD explicit CoveredBox(const StepView& v, const MeshConstants& m) {
    const FieldBox& field = m.field;
    for (int a = 0; a < 3; ++a) {
      low[a] = larger(-0.5f, (-0.5f - field.shift[a]) / field.scale[a]);
      high[a] = smaller(v.volume.size[a] - 0.5f, (field.size[a] - 0.5f - field.shift[a]) / field.scale[a]);
    }
  }
  /// Distance to the nearest face along an axis, voxels; negative outside.
  template <class R>
  SIMPLEXSEG_HD R depth(Vec3Of<R> at) const {
    const R x = smaller(at.x - low[0], high[0] - at.x), y = smaller(at.y - low[1], high[1] - at.y),
            z = smaller(at.z - low[2], high[2] - at.z);
    return smaller(x, smaller(y, z));
  }
};

/// Displacement (mm, world axes, at most `max_mm` long) towards the object of the mesh's field, from a position `at`
/// (voxel index) where P is about 0, or beyond the box: then to the box, and from there to the object.
template <class R>
SIMPLEXSEG_HD Vec3Of<R> vector_to_object(const StepView& v, const MeshConstants& m, Vec3Of<R> at, R max_mm) {
  const VolumeView field = field_view(v, m);
  const Vec3Of<R> from = m.field.index(at);
  const Vec3Of<R> p = {smaller(larger(from.x, R(0.0f)), R(m.field.size[0] - 1.0f)),
                       smaller(larger(from.y, R(0.0f)), R(m.field.size[1] - 1.0f)),
                       smaller(larger(from.z, R(0.0f)), R(m.field.size[2] - 1.0f))};
  const CellOf<R> c = cell_at(field, p);
  const CornersOf<R> q = LinearVoxels<std::uint16_t>(field).corners(c);
  const R value = interpolate(q, c), distance_cells = larger(kFieldFloor - value, R(0.0f)) / kFieldFall;
  const Vec3Of<R> ascent = gradient(field, q, c), none{0, 0, 0};
  const R size = norm(ascent);
  const Vec3Of<R> beyond = p - from;  // indices of cells
  const BooleanOf<R> is_in_box = dot(beyond, beyond) <= 0.0f;
  const Vec3Of<R> in_box = choose((size > 0.0f) & (is_in_box | (value <= 0.5f * kFieldScale)),
                                  (smaller((distance_cells + 1.0f) * m.field.cell_mm, max_mm) / size) * ascent, none);
  // A row of the matrix, divided by its square, is the shortest displacement that changes the index of its axis by 1.
  const float* const rows = field.index_from_world;
  auto along = [&](int a, R cells) SIMPLEXSEG_INLINED {
    const Vec3 row{rows[4 * a], rows[4 * a + 1], rows[4 * a + 2]};
    const R share = cells * (1.0f / dot(row, row));
    return Vec3Of<R>{row.x * share, row.y * share, row.z * share};
  };
  const Vec3Of<R> sum = in_box + along(0, beyond.x) + along(1, beyond.y) + along(2, beyond.z);
  const R length = norm(sum);
  return choose(length > max_mm, (max_mm / length) * sum, sum);
}

/// Weight of the field's descent direction relative to the normal in a search line.
inline constexpr float kDescentWeight = 4;

/// Search direction through the surface of a field: the normal n, tilted towards the field's descent direction if their
/// angle is below 90 degrees. Normals alone are too rough on thin parts and on coarse meshes. `alignment`: cosine
/// between n and the descent direction, reduced towards 0 where the field is flat.
template <class R>
struct SearchLine {
  Vec3Of<R> direction;
  R alignment;
};
template <class R>
SIMPLEXSEG_HD SearchLine<R> field_search_line(const StepView& v, const MeshConstants& m, Vec3Of<R> at, Vec3Of<R> n) {
  const VolumeView field = field_view(v, m);
  const CellOf<R> c = cell_at(field, m.field.index(at));
  const Vec3Of<R> descent = -1.0f * gradient(field, LinearVoxels<std::uint16_t>(field).corners(c), c);
  const R size = norm(descent);
  const auto has_descent = size > 0.0f;
  if (!any(has_descent)) return {n, 0.0f};
  const R alignment = smaller(size * m.field.cell_mm / (kFlatField * kFieldScale), R(1.0f)) * dot(descent, n) / size;
  const Vec3Of<R> tilted = n + (kDescentWeight * larger(alignment, R(0.0f)) / size) * descent;
  return {choose(has_descent, (1.0f / norm(tilted)) * tilted, n), choose(has_descent, alignment, R(0.0f))};
}

}  // namespace simplexseg
