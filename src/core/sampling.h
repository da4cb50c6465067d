// SPDX-License-Identifier: Apache-2.0
// Trilinear sampling of a volume in its own voxel type, along a line in world space.
#pragma once
#include <type_traits>

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

/// What a sample outside of the volume is (by more than half a voxel outside the centres of the outer voxels): NaN, as a voxel
/// that is not a number. Neither counts.
SIMPLEXSEG_HD bool is_valid(float sample) { return fabsf(sample) <= 3e38f; }

/// The cell of eight voxels around an index position and the fractions within it. A position outside of the volume gets a
/// cell at its border, so that reading it is always allowed.
struct Cell {
  int i, j, k;
  float fx, fy, fz;
  bool inside;
};
SIMPLEXSEG_HD Cell cell_at(const VolumeView& v, Vec3 p) {
  const float hx = v.size[0] - 1.0f, hy = v.size[1] - 1.0f, hz = v.size[2] - 1.0f;
  const bool inside = (p.x >= -0.5f) & (p.y >= -0.5f) & (p.z >= -0.5f) & (p.x <= hx + 0.5f) & (p.y <= hy + 0.5f) & (p.z <= hz + 0.5f);
  // Comparisons rather than fmin and fmax: NaN becomes 0, and they vectorise.
  float x = p.x > 0.0f ? p.x : 0.0f, y = p.y > 0.0f ? p.y : 0.0f, z = p.z > 0.0f ? p.z : 0.0f;
  x = x < hx ? x : hx, y = y < hy ? y : hy, z = z < hz ? z : hz;
  int i = static_cast<int>(x), j = static_cast<int>(y), k = static_cast<int>(z);
  const int li = v.size[0] > 1 ? v.size[0] - 2 : 0, lj = v.size[1] > 1 ? v.size[1] - 2 : 0, lk = v.size[2] > 1 ? v.size[2] - 2 : 0;
  i = i < li ? i : li, j = j < lj ? j : lj, k = k < lk ? k : lk;
  return {i, j, k, x - i, y - j, z - k, inside};
}
SIMPLEXSEG_HD float mix(float a, float b, float f) { return a + f * (b - a); }

/// The voxels of a cell as float, i fastest.
template <class T>
struct CellReader {
  const T* voxels;
  long row, plane, dx, dy, dz;     ///< strides; to the next voxel 0 where the volume is one voxel wide
  SIMPLEXSEG_HD explicit CellReader(const VolumeView& v)
      : voxels(static_cast<const T*>(v.voxels)), row(v.size[0]), plane(row * v.size[1]),
        dx(v.size[0] > 1 ? 1 : 0), dy(v.size[1] > 1 ? row : 0), dz(v.size[2] > 1 ? plane : 0) {}
  SIMPLEXSEG_HD const T* at(int i, int j, int k) const { return voxels + k * plane + j * row + i; }
};

/// Intensities at start, start + step, ... (mm) along a line: trilinear, `count` of them.
template <class T>
SIMPLEXSEG_HD void sample_line(const VolumeView& v, IndexLine line, float start, float step, int count, float* values) {
  const CellReader<T> read(v);
#ifdef __CUDA_ARCH__
  for (int s = 0; s < count; ++s) {
    const Cell c = cell_at(v, line.origin + (start + s * step) * line.direction);
    const T* b = read.at(c.i, c.j, c.k);
    const float c00 = mix(b[0], b[read.dx], c.fx), c10 = mix(b[read.dy], b[read.dy + read.dx], c.fx);
    const float c01 = mix(b[read.dz], b[read.dz + read.dx], c.fx), c11 = mix(b[read.dz + read.dy], b[read.dz + read.dy + read.dx], c.fx);
    values[s] = c.inside ? mix(mix(c00, c10, c.fy), mix(c01, c11, c.fy), c.fz) : NAN;
  }
#else
  // Positions and mixing in vectors of samples, reading one by one: voxels of 8 and 16 bits cannot be gathered.
  constexpr int kLanes = 8;
  // Integers are turned into float in vectors too.
  using Read = std::conditional_t<std::is_integral_v<T> && !std::is_same_v<T, std::uint32_t>, int, float>;
  for (int first = 0; first < count; first += kLanes) {
    alignas(64) int ci[kLanes], cj[kLanes], ck[kLanes];
    alignas(64) float fx[kLanes], fy[kLanes], fz[kLanes], outside[kLanes], result[kLanes];
    alignas(64) Read corner[8][kLanes];
    for (int s = 0; s < kLanes; ++s) {
      const Cell c = cell_at(v, line.origin + (start + (first + s) * step) * line.direction);
      ci[s] = c.i, cj[s] = c.j, ck[s] = c.k, fx[s] = c.fx, fy[s] = c.fy, fz[s] = c.fz;
      outside[s] = c.inside ? 0.0f : NAN;
    }
    for (int s = 0; s < kLanes; ++s) {     // those past the end too: a fixed count costs less than the reads
      const T* b = read.at(ci[s], cj[s], ck[s]);
      corner[0][s] = static_cast<Read>(b[0]), corner[1][s] = static_cast<Read>(b[read.dx]);
      corner[2][s] = static_cast<Read>(b[read.dy]), corner[3][s] = static_cast<Read>(b[read.dy + read.dx]);
      b += read.dz;
      corner[4][s] = static_cast<Read>(b[0]), corner[5][s] = static_cast<Read>(b[read.dx]);
      corner[6][s] = static_cast<Read>(b[read.dy]), corner[7][s] = static_cast<Read>(b[read.dy + read.dx]);
    }
    for (int s = 0; s < kLanes; ++s) {
      auto at = [&](int c) { return static_cast<float>(corner[c][s]); };
      const float low = mix(mix(at(0), at(1), fx[s]), mix(at(2), at(3), fx[s]), fy[s]);
      const float high = mix(mix(at(4), at(5), fx[s]), mix(at(6), at(7), fx[s]), fy[s]);
      result[s] = mix(low, high, fz[s]) + outside[s];
    }
    if (count - first >= kLanes) {
      for (int s = 0; s < kLanes; ++s) values[first + s] = result[s];
    } else {
      for (int s = 0; first + s < count; ++s) values[first + s] = result[s];
    }
  }
#endif
}

/// Magnitude of the gradient (per mm) of the trilinear interpolant at index position p; NaN outside.
template <class T>
SIMPLEXSEG_HD float gradient_magnitude_at(const VolumeView& v, Vec3 p) {
  const Cell c = cell_at(v, p);
  const CellReader<T> read(v);
  const T* b = read.at(c.i, c.j, c.k);
  auto at = [b](long offset) { return static_cast<float>(b[offset]); };
  const float v000 = at(0), v100 = at(read.dx), v010 = at(read.dy), v110 = at(read.dy + read.dx);
  const float v001 = at(read.dz), v101 = at(read.dz + read.dx), v011 = at(read.dz + read.dy), v111 = at(read.dz + read.dy + read.dx);
  const float gi = mix(mix(v100 - v000, v110 - v010, c.fy), mix(v101 - v001, v111 - v011, c.fy), c.fz);
  const float gj = mix(mix(v010 - v000, v110 - v100, c.fx), mix(v011 - v001, v111 - v101, c.fx), c.fz);
  const float gk = mix(mix(v001 - v000, v101 - v100, c.fx), mix(v011 - v010, v111 - v110, c.fx), c.fy);
  const float* m = v.index_from_world;    // chain rule: the transpose maps index gradients to world
  const Vec3 g{m[0] * gi + m[4] * gj + m[8] * gk, m[1] * gi + m[5] * gj + m[9] * gk, m[2] * gi + m[6] * gj + m[10] * gk};
  return c.inside ? norm(g) : NAN;
}

}  // namespace simplexseg
