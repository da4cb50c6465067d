// SPDX-License-Identifier: Apache-2.0
// Trilinear sampling of a volume along a line in world space. A sampler is one way to read it:
//   LinearVoxels<T>    voxels of type T in linear memory, interpolated in float: the CPU's, and a device's where its
//   texture
//                      unit cannot filter T
//   FetchedVoxels      texels of a 3D texture, interpolated in float
//   FilteredVoxels     interpolated by the texture unit, whose fractions have 8 bits: up to 1/256 of the difference of
//   two
//                      neighbouring voxels off along each axis (docs/adr/0008-textures.md says what that costs)
#pragma once
#include <type_traits>

#include "forces/lanes.h"
#include "forces/step_view.h"

namespace simplexseg {

/// A line origin + t * direction in voxel index space, t in mm.
template <class R>
struct IndexLineOf {
  Vec3Of<R> origin, direction;
};
using IndexLine = IndexLineOf<float>;
template <class R>
SIMPLEXSEG_HD Vec3Of<R> rotate_to_index(const VolumeView& v, Vec3Of<R> d) {
  const float* m = v.index_from_world;
  return {m[0] * d.x + m[1] * d.y + m[2] * d.z, m[4] * d.x + m[5] * d.y + m[6] * d.z,
          m[8] * d.x + m[9] * d.y + m[10] * d.z};
}
template <class R>
SIMPLEXSEG_HD IndexLineOf<R> index_line(const VolumeView& v, Vec3Of<R> origin_mm, Vec3Of<R> unit_direction) {
  const float* m = v.index_from_world;
  return {rotate_to_index(v, origin_mm) + Vec3Of<R>{m[3], m[7], m[11]}, rotate_to_index(v, unit_direction)};
}

/// What a sample outside of the volume is (by more than half a voxel outside the centres of the outer voxels): NaN, as
/// a voxel that is not a number. Neither counts.
template <class R>
SIMPLEXSEG_HD auto is_valid(R sample) {
  return fabsf(sample) <= 3e38f;
}

/// The cell of eight voxels around an index position and the fractions within it. A position outside of the volume gets
/// a cell at its border, so that reading it is always allowed.
template <class R>
struct CellOf {
  Whole<R> i, j, k;
  R fx, fy, fz;
  Answer<R> inside;
};
using Cell = CellOf<float>;
template <class R>
SIMPLEXSEG_HD CellOf<R> cell_at(const VolumeView& v, Vec3Of<R> p) {
  const float hx = v.size[0] - 1.0f, hy = v.size[1] - 1.0f, hz = v.size[2] - 1.0f;
  const Answer<R> inside =
      (p.x >= -0.5f) & (p.y >= -0.5f) & (p.z >= -0.5f) & (p.x <= hx + 0.5f) & (p.y <= hy + 0.5f) & (p.z <= hz + 0.5f);
  // Comparisons rather than fmin and fmax: NaN becomes 0, and they vectorise.
  const R x = smaller(larger(p.x, 0.0f), hx), y = smaller(larger(p.y, 0.0f), hy), z = smaller(larger(p.z, 0.0f), hz);
  const int li = v.size[0] > 1 ? v.size[0] - 2 : 0, lj = v.size[1] > 1 ? v.size[1] - 2 : 0,
            lk = v.size[2] > 1 ? v.size[2] - 2 : 0;
  const Whole<R> i = smaller(whole_of(x), li), j = smaller(whole_of(y), lj), k = smaller(whole_of(z), lk);
  return {i, j, k, x - real_of(i), y - real_of(j), z - real_of(k), inside};
}
template <class R>
SIMPLEXSEG_HD R mix(R a, R b, R f) {
  return a + f * (b - a);
}

/// The trilinear interpolant, its gradient (per mm) and that one's magnitude from the eight voxels of a cell, i
/// fastest.
template <class R>
struct CornersOf {
  R v000, v100, v010, v110, v001, v101, v011, v111;
};
using Corners = CornersOf<float>;
template <class R>
SIMPLEXSEG_HD R interpolate(const CornersOf<R>& v, const CellOf<R>& c) {
  const R low = mix(mix(v.v000, v.v100, c.fx), mix(v.v010, v.v110, c.fx), c.fy);
  const R high = mix(mix(v.v001, v.v101, c.fx), mix(v.v011, v.v111, c.fx), c.fy);
  return mix(low, high, c.fz);
}
template <class R>
SIMPLEXSEG_HD Vec3Of<R> gradient(const VolumeView& view, const CornersOf<R>& v, const CellOf<R>& c) {
  const R gi = mix(mix(v.v100 - v.v000, v.v110 - v.v010, c.fy), mix(v.v101 - v.v001, v.v111 - v.v011, c.fy), c.fz);
  const R gj = mix(mix(v.v010 - v.v000, v.v110 - v.v100, c.fx), mix(v.v011 - v.v001, v.v111 - v.v101, c.fx), c.fz);
  const R gk = mix(mix(v.v001 - v.v000, v.v101 - v.v100, c.fx), mix(v.v011 - v.v010, v.v111 - v.v110, c.fx), c.fy);
  const float* m = view.index_from_world;  // chain rule: the transpose maps index gradients to world
  return {m[0] * gi + m[4] * gj + m[8] * gk, m[1] * gi + m[5] * gj + m[9] * gk, m[2] * gi + m[6] * gj + m[10] * gk};
}
template <class R>
SIMPLEXSEG_HD R gradient_magnitude(const VolumeView& view, const CornersOf<R>& v, const CellOf<R>& c) {
  return norm(gradient(view, v, c));
}

template <class T>
struct LinearVoxels {
  const T* voxels;
  long row, plane, dx, dy, dz;  ///< strides; to the next voxel 0 where the volume is one voxel wide
  SIMPLEXSEG_HD explicit LinearVoxels(const VolumeView& v)
      : voxels(static_cast<const T*>(v.voxels)),
        row(v.size[0]),
        plane(row * v.size[1]),
        dx(v.size[0] > 1 ? 1 : 0),
        dy(v.size[1] > 1 ? row : 0),
        dz(v.size[2] > 1 ? plane : 0) {}
  SIMPLEXSEG_HD const T* at(int i, int j, int k) const { return voxels + k * plane + j * row + i; }
  SIMPLEXSEG_HD Corners corners(const Cell& c) const {
    const T* b = at(c.i, c.j, c.k);
    auto read = [b](long offset) { return static_cast<float>(b[offset]); };
    return {read(0), read(dx), read(dy), read(dy + dx), read(dz), read(dz + dx), read(dz + dy), read(dz + dy + dx)};
  }
  /// Those of several cells (forces/eight.h).
  template <class R>
  SIMPLEXSEG_HD CornersOf<R> corners(const CellOf<R>& c) const {
    return corners_of(*this, c);
  }
  /// At an index position; NaN outside.
  template <class R>
  SIMPLEXSEG_HD R sample(const VolumeView& v, Vec3Of<R> p) const {
    const CellOf<R> c = cell_at(v, p);
    return choose(c.inside, interpolate(corners(c), c), R(NAN));
  }
#ifdef __CUDACC__
  // For positions that are known to be inside and were `placed`; the result is to be `scaled`.
  __device__ static Vec3 placed(Vec3 p) { return p; }
  __device__ float scaled(float texel) const { return texel; }
  __device__ float texel(const VolumeView& v, Vec3 p) const {
    const Cell c = cell_at(v, p);
    return interpolate(corners(c), c);
  }
#endif
};

#ifdef __CUDACC__
struct FetchedVoxels {
  unsigned long long texture;
  float scale;
  __device__ explicit FetchedVoxels(const VolumeView& v) : texture(v.fetched), scale(v.texel_scale) {}
  __device__ Corners corners(const Cell& c) const {
    const float x = c.i + 0.5f, y = c.j + 0.5f, z = c.k + 0.5f;
    auto read = [&](float dx, float dy, float dz) { return scale * tex3D<float>(texture, x + dx, y + dy, z + dz); };
    return {read(0, 0, 0), read(1, 0, 0), read(0, 1, 0), read(1, 1, 0),
            read(0, 0, 1), read(1, 0, 1), read(0, 1, 1), read(1, 1, 1)};
  }
  __device__ float sample(const VolumeView& v, Vec3 p) const {
    const Cell c = cell_at(v, p);
    const float value = interpolate(corners(c), c);
    return c.inside ? value : NAN;
  }
  // For positions that are known to be inside and were `placed`; the result is to be `scaled`.
  __device__ static Vec3 placed(Vec3 p) { return p; }
  __device__ float scaled(float texel) const { return texel; }
  __device__ float texel(const VolumeView& v, Vec3 p) const {
    const Cell c = cell_at(v, p);
    return interpolate(corners(c), c);
  }
};
struct FilteredVoxels {
  unsigned long long texture;
  float scale;
  FetchedVoxels fetched;
  __device__ explicit FilteredVoxels(const VolumeView& v) : texture(v.filtered), scale(v.texel_scale), fetched(v) {}
  __device__ Corners corners(const Cell& c) const { return fetched.corners(c); }
  __device__ float sample(const VolumeView& v, Vec3 p) const {
    const bool inside = (p.x >= -0.5f) & (p.y >= -0.5f) & (p.z >= -0.5f) & (p.x <= v.size[0] - 0.5f) &
                        (p.y <= v.size[1] - 0.5f) & (p.z <= v.size[2] - 0.5f);
    const float value = scale * tex3D<float>(texture, p.x + 0.5f, p.y + 0.5f, p.z + 0.5f);
    return inside ? value : NAN;
  }
  __device__ static Vec3 placed(Vec3 p) { return p + Vec3{0.5f, 0.5f, 0.5f}; }
  __device__ float scaled(float texel) const { return scale * texel; }
  __device__ float texel(const VolumeView&, Vec3 p) const { return tex3D<float>(texture, p.x, p.y, p.z); }
};
#endif

/// True when the whole of a line between two of its points lies in the volume: it is convex.
SIMPLEXSEG_HD bool contains(const VolumeView& v, IndexLine line, float start, float end) {
  const Vec3 a = line.origin + start * line.direction, b = line.origin + end * line.direction;
  const Vec3 low{smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z)},
      high{larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)};
  return (low.x >= -0.5f) & (low.y >= -0.5f) & (low.z >= -0.5f) & (high.x <= v.size[0] - 0.5f) &
         (high.y <= v.size[1] - 0.5f) & (high.z <= v.size[2] - 0.5f);
}

#ifndef __CUDA_ARCH__
/// On the CPU positions and mixing in vectors of samples, reading one by one: voxels of 8 and 16 bits cannot be
/// gathered.
template <class T>
inline __attribute__((always_inline)) void sample_line_in_vectors(const LinearVoxels<T>& read, const VolumeView& v,
                                                                  IndexLine line, float start, float step, int count,
                                                                  float* values) {
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
    for (int s = 0; s < kLanes; ++s) {  // those past the end too: a fixed count costs less than the reads
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
}
#endif

/// Intensities, less `base`, at start, start + step, ... (mm) along a line: trilinear, `count` of them, shared out over
/// the lanes; NaN outside.
template <class Voxels, class L, class Values, class R, class Shift>
SIMPLEXSEG_HD void sample_line(const Voxels& read, const VolumeView& v, L lanes, IndexLineOf<R> line, Shift start,
                               Shift step, int count, Values& values, float base = 0.0f) {
#ifdef __CUDA_ARCH__
  if (contains(v, line, start, start + (count - 1) * step)) {
    const Vec3 first = read.placed(line.origin + start * line.direction), each = step * line.direction;
    // Loads of a whole round at once, none of which waits for another; those past the end read the last sample.
    constexpr int kRound = 8;
    for (int from = lanes.lane; from < count; from += kRound * L::width) {
      float texels[kRound];
#pragma unroll
      for (int k = 0; k < kRound; ++k)
        texels[k] = read.texel(v, first + static_cast<float>(smaller(from + k * L::width, count - 1)) * each);
#pragma unroll
      for (int k = 0; k < kRound; ++k)
        if (const int s = from + k * L::width; s < count) values[s] = read.scaled(texels[k]) - base;
    }
  } else {
    for (int s = lanes.lane; s < count; s += L::width)
      values[s] = read.sample(v, line.origin + (start + s * step) * line.direction) - base;
  }
#else
  if constexpr (std::is_same_v<R, float>)
    sample_line_in_vectors(read, v, line, start, step, count, &values[0]);
  else
    for (int s = 0; s < count; ++s) values[s] = read.sample(v, line.origin + (start + s * step) * line.direction);
  if (base != 0.0f)
    for (int s = 0; s < count; ++s) values[s] -= base;
#endif
  lanes.sync();
}

/// The samples along a line, each read when its turn comes: k = 0, 1, 2 ... in this order. `kWhole`: the line is known
/// to lie in the volume, on a device.
template <class Voxels, bool kWhole, class R = float>
struct SampleStream {
  const Voxels& read;
  const VolumeView& v;
  IndexLineOf<R> line;
  R start, step;
  Vec3Of<R> first, each;
  R here, after;
  SIMPLEXSEG_HD SampleStream(const Voxels& voxels, const VolumeView& view, IndexLineOf<R> l, R from, R by)
      : read(voxels),
        v(view),
        line(l),
        start(from),
        step(by),
        first(l.origin + from * l.direction),
        each(by * l.direction) {
#ifdef __CUDA_ARCH__
    if constexpr (kWhole) first = voxels.placed(first);
#endif
    here = at(0), after = at(1);
  }
  SIMPLEXSEG_HD R at(int k) const {
#ifdef __CUDA_ARCH__
    if constexpr (kWhole) return read.scaled(read.texel(v, first + static_cast<float>(k) * each));
#endif
    return read.sample(v, line.origin + (start + static_cast<float>(k) * step) * line.direction);
  }
  /// f(sample k, sample k + 1, sample k + 2).
  template <class F>
  SIMPLEXSEG_HD R next(int k, F f) {
    const R before = here;
    here = after, after = at(k + 2);
    return f(before, here, after);
  }
};

/// Magnitude of the gradient (per mm) of the trilinear interpolant at index position p; NaN outside.
template <class Voxels, class R>
SIMPLEXSEG_HD R gradient_magnitude_at(const Voxels& read, const VolumeView& v, Vec3Of<R> p) {
  const CellOf<R> c = cell_at(v, p);
  return choose(c.inside, gradient_magnitude(v, read.corners(c), c), R(NAN));
}

}  // namespace simplexseg
