// SPDX-License-Identifier: Apache-2.0
// Trilinear sampling of a volume in its own voxel type, along a line in world space.
#pragma once
#include "core/step_view.h"

namespace simplexseg {

/// A line origin + t * direction in voxel index space, t in mm.
struct IndexLine {
  Vec3 origin, direction;
};
SIMPLEXSEG_HD Vec3 rotate_to_index(const VolumeView& v, Vec3 d) {
  const float* m = v.index_from_world;
  return {m[0] * d.x + m[1] * d.y + m[2] * d.z, m[4] * d.x + m[5] * d.y + m[6] * d.z,
          m[8] * d.x + m[9] * d.y + m[10] * d.z};
}
SIMPLEXSEG_HD IndexLine index_line(const VolumeView& v, Vec3 origin_mm, Vec3 unit_direction) {
  const float* m = v.index_from_world;
  return {rotate_to_index(v, origin_mm) + Vec3{m[3], m[7], m[11]}, rotate_to_index(v, unit_direction)};
}

struct Sample {
  float value;
  bool inside;           ///< false: the position lies outside the centres of the outer voxels (by more than half a voxel)
};

/// The eight voxels around an index position and the fractions between them.
template <class T>
struct Corner {
  const T* base;
  long dx, dy, dz;       ///< strides to the upper corner; 0 at an upper face
  float fx, fy, fz;
  bool inside;
};
template <class T>
SIMPLEXSEG_HD Corner<T> corner_at(const VolumeView& v, Vec3 p) {
  const bool inside = p.x >= -0.5f && p.y >= -0.5f && p.z >= -0.5f && p.x <= v.size[0] - 0.5f &&
                      p.y <= v.size[1] - 0.5f && p.z <= v.size[2] - 0.5f;
  if (!inside) return {static_cast<const T*>(v.voxels), 0, 0, 0, 0.0f, 0.0f, 0.0f, false};   // NaN comes here too
  const float x = fminf(fmaxf(p.x, 0.0f), v.size[0] - 1.0f), y = fminf(fmaxf(p.y, 0.0f), v.size[1] - 1.0f),
              z = fminf(fmaxf(p.z, 0.0f), v.size[2] - 1.0f);
  const int i = static_cast<int>(x), j = static_cast<int>(y), k = static_cast<int>(z);
  const long row = v.size[0], plane = row * v.size[1];
  return {static_cast<const T*>(v.voxels) + k * plane + j * row + i,
          i + 1 < v.size[0] ? 1 : 0, j + 1 < v.size[1] ? row : 0, k + 1 < v.size[2] ? plane : 0,
          x - i, y - j, z - k, true};
}
template <class T>
SIMPLEXSEG_HD float mix_corner(const Corner<T>& c) {
  const T* b = c.base;
  auto lerp = [](float a, float d, float f) { return a + f * (d - a); };
  const float c00 = lerp(static_cast<float>(b[0]), static_cast<float>(b[c.dx]), c.fx);
  const float c10 = lerp(static_cast<float>(b[c.dy]), static_cast<float>(b[c.dy + c.dx]), c.fx);
  const float c01 = lerp(static_cast<float>(b[c.dz]), static_cast<float>(b[c.dz + c.dx]), c.fx);
  const float c11 = lerp(static_cast<float>(b[c.dz + c.dy]), static_cast<float>(b[c.dz + c.dy + c.dx]), c.fx);
  return lerp(lerp(c00, c10, c.fy), lerp(c01, c11, c.fy), c.fz);
}
/// Intensity at index position p; {0, false} outside.
template <class T>
SIMPLEXSEG_HD Sample sample_at(const VolumeView& v, Vec3 p) {
  const Corner<T> c = corner_at<T>(v, p);
  return {c.inside ? mix_corner(c) : 0.0f, c.inside};
}
/// Squared magnitude of the gradient (per mm) of the trilinear interpolant at index position p; {0, false} outside.
template <class T>
SIMPLEXSEG_HD Sample squared_gradient_at(const VolumeView& v, Vec3 p) {
  const Corner<T> c = corner_at<T>(v, p);
  if (!c.inside) return {0.0f, false};
  const T* b = c.base;
  const float v000 = static_cast<float>(b[0]), v100 = static_cast<float>(b[c.dx]);
  const float v010 = static_cast<float>(b[c.dy]), v110 = static_cast<float>(b[c.dy + c.dx]);
  const float v001 = static_cast<float>(b[c.dz]), v101 = static_cast<float>(b[c.dz + c.dx]);
  const float v011 = static_cast<float>(b[c.dz + c.dy]), v111 = static_cast<float>(b[c.dz + c.dy + c.dx]);
  auto lerp = [](float a, float d, float f) { return a + f * (d - a); };
  const float gi = lerp(lerp(v100 - v000, v110 - v010, c.fy), lerp(v101 - v001, v111 - v011, c.fy), c.fz);
  const float gj = lerp(lerp(v010 - v000, v110 - v100, c.fx), lerp(v011 - v001, v111 - v101, c.fx), c.fz);
  const float gk = lerp(lerp(v001 - v000, v101 - v100, c.fx), lerp(v011 - v010, v111 - v110, c.fx), c.fy);
  const float* m = v.index_from_world;    // chain rule: the transpose maps index gradients to world
  const Vec3 g{m[0] * gi + m[4] * gj + m[8] * gk, m[1] * gi + m[5] * gj + m[9] * gk, m[2] * gi + m[6] * gj + m[10] * gk};
  return {dot(g, g), true};
}

}  // namespace simplexseg
