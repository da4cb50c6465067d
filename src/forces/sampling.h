// SPDX-License-Identifier: Apache-2.0
// Trilinear sampling of a volume along a line in world space. Samplers:
//   LinearVoxels<T>  Voxels of type T in linear memory, interpolated in float. Used on the CPU, and on a device for
//                    types T that its texture unit cannot filter.
//   FetchedVoxels    Texels of a 3D texture, interpolated in float.
//   FilteredVoxels   Texels interpolated by the texture unit with fractions of 8 bits: an error of up to 1/256 of the
//                    difference of two neighbouring voxels along each axis (effect: docs/adr/0008-textures.md).
#pragma once
#include <type_traits>

#include "forces/lanes.h"
#include "forces/step_view.h"

namespace simplexseg {

/// Line origin + t * direction in voxel index space, t in mm.
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

/// True if a sample is finite. Samples are NaN at NaN voxels, and more than half a voxel beyond the centres of the
/// outermost voxels.
template <class R>
SIMPLEXSEG_HD auto is_valid(R sample) {
  return fabsf(sample) <= 3e38f;
}

/// Cell of eight voxels around an index position, and the fractional coordinates of the position within the cell.
/// Positions outside the volume get a cell at its border, whose voxels can always be read. `inside`: the position is at
/// most half a voxel beyond the centres of the outermost voxels.
template <class R>
struct CellOf {
  IntegerOf<R> i, j, k;
  R fx, fy, fz;
  BooleanOf<R> inside;
};
using Cell = CellOf<float>;
template <class R>
SIMPLEXSEG_HD CellOf<R> cell_at(const VolumeView& v, Vec3Of<R> p) {
  const float hx = v.size[0] - 1.0f, hy = v.size[1] - 1.0f, hz = v.size[2] - 1.0f;
  const BooleanOf<R> inside =
      (p.x >= -0.5f) & (p.y >= -0.5f) & (p.z >= -0.5f) & (p.x <= hx + 0.5f) & (p.y <= hy + 0.5f) & (p.z <= hz + 0.5f);
  // The comparisons map NaN to 0 and, unlike fmin and fmax, can be vectorised.
  const R x = smaller(larger(p.x, 0.0f), hx), y = smaller(larger(p.y, 0.0f), hy), z = smaller(larger(p.z, 0.0f), hz);
  const int li = v.size[0] > 1 ? v.size[0] - 2 : 0, lj = v.size[1] > 1 ? v.size[1] - 2 : 0,
            lk = v.size[2] > 1 ? v.size[2] - 2 : 0;
  const IntegerOf<R> i = smaller(to_integer(x), li), j = smaller(to_integer(y), lj), k = smaller(to_integer(z), lk);
  return {i, j, k, x - to_real(i), y - to_real(j), z - to_real(k), inside};
}
template <class R>
SIMPLEXSEG_HD R mix(R a, R b, R f) {
  return a + f * (b - a);
}

/// Intensities of the eight voxels of a cell, i fastest. From these, the functions below compute the trilinear
/// interpolant, its gradient in world space (per mm) and the magnitude of the gradient.
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
  long row, plane, dx, dy, dz;  ///< strides, voxels; dx, dy, dz are 0 along axes of one voxel
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
  /// Corners of several cells at once (forces/eight.h).
  template <class R>
  SIMPLEXSEG_HD CornersOf<R> corners(const CellOf<R>& c) const {
    return corners_of(*this, c);
  }
  /// Interpolated value at an index position; NaN outside the volume.
  template <class R>
  SIMPLEXSEG_HD R sample(const VolumeView& v, Vec3Of<R> p) const {
    const CellOf<R> c = cell_at(v, p);
    return choose(c.inside, interpolate(corners(c), c), R(NAN));
  }
#ifdef __CUDACC__
  // texel() requires a position inside the volume, converted by texture_position(). Convert its result by
  // to_intensity().
  __device__ static Vec3 texture_position(Vec3 p) { return p; }
  __device__ float to_intensity(float texel) const { return texel; }
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
  // texel() requires a position inside the volume, converted by texture_position(). Convert its result by
  // to_intensity().
  __device__ static Vec3 texture_position(Vec3 p) { return p; }
  __device__ float to_intensity(float texel) const { return texel; }
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
  __device__ static Vec3 texture_position(Vec3 p) { return p + Vec3{0.5f, 0.5f, 0.5f}; }
  __device__ float to_intensity(float texel) const { return scale * texel; }
  __device__ float texel(const VolumeView&, Vec3 p) const { return tex3D<float>(texture, p.x, p.y, p.z); }
};
#endif

/// True if the segment of a line from `start` to `end` (mm) lies inside the volume. Tests only its ends, since the
/// volume is convex.
SIMPLEXSEG_HD bool contains(const VolumeView& v, IndexLine line, float start, float end) {
  const Vec3 a = line.origin + start * line.direction, b = line.origin + end * line.direction;
  const Vec3 low{smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z)},
      high{larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)};
  return (low.x >= -0.5f) & (low.y >= -0.5f) & (low.z >= -0.5f) & (high.x <= v.size[0] - 0.5f) &
         (high.y <= v.size[1] - 0.5f) & (high.z <= v.size[2] - 0.5f);
}

#ifndef __CUDA_ARCH__
/// Samples a line on the CPU at start, start + step, ... (mm). Positions and interpolation are vectorised over samples.
/// Voxels are read individually, since there are no gather instructions for 8 and 16 bits.
template <class T>
inline __attribute__((always_inline)) void sample_line_in_vectors(const LinearVoxels<T>& read, const VolumeView& v,
                                                                  IndexLine line, float start, float step, int count,
                                                                  float* values) {
  constexpr int kLanes = 8;
  // Integers are stored as int, so that their conversion to float is vectorised, too.
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
    for (int s = 0; s < kLanes; ++s) {  // constant count: reading past the last sample costs less than a variable count
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

/// Samples `count` intensities minus `base` at start, start + step, ... (mm) along a line, distributed over the lanes.
/// The interpolation is trilinear; samples outside the volume are NaN.
template <class Voxels, class L, class Values, class R, class Shift>
SIMPLEXSEG_HD void sample_line(const Voxels& read, const VolumeView& v, L lanes, IndexLineOf<R> line, Shift start,
                               Shift step, int count, Values& values, float base = 0.0f) {
#ifdef __CUDA_ARCH__
  if (contains(v, line, start, start + (count - 1) * step)) {
    const Vec3 first = read.texture_position(line.origin + start * line.direction), each = step * line.direction;
    // All loads of a batch are issued together. Loads past the end read the last sample.
    constexpr int kBatch = 8;
    for (int from = lanes.lane; from < count; from += kBatch * L::width) {
      float texels[kBatch];
#pragma unroll
      for (int k = 0; k < kBatch; ++k)
        texels[k] = read.texel(v, first + static_cast<float>(smaller(from + k * L::width, count - 1)) * each);
#pragma unroll
      for (int k = 0; k < kBatch; ++k)
        if (const int s = from + k * L::width; s < count) values[s] = read.to_intensity(texels[k]) - base;
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

/// Stream of samples along a line, read on demand in the order k = 0, 1, 2 ... `kInside`: true if all samples lie in
/// the volume, which saves the tests on a device.
template <class Voxels, bool kInside, class R = float>
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
    if constexpr (kInside) first = voxels.texture_position(first);
#endif
    here = at(0), after = at(1);
  }
  SIMPLEXSEG_HD R at(int k) const {
#ifdef __CUDA_ARCH__
    if constexpr (kInside) return read.to_intensity(read.texel(v, first + static_cast<float>(k) * each));
#endif
    return read.sample(v, line.origin + (start + static_cast<float>(k) * step) * line.direction);
  }
  /// Returns f(sample k, sample k + 1, sample k + 2). Requires calls with k = 0, 1, 2 ...
  template <class F>
  SIMPLEXSEG_HD R next(int k, F f) {
    const R before = here;
    here = after, after = at(k + 2);
    return f(before, here, after);
  }
};

/// Magnitude of the gradient (per mm) of the trilinear interpolant at index position p; NaN outside the volume.
template <class Voxels, class R>
SIMPLEXSEG_HD R gradient_magnitude_at(const Voxels& read, const VolumeView& v, Vec3Of<R> p) {
  const CellOf<R> c = cell_at(v, p);
  return choose(c.inside, gradient_magnitude(v, read.corners(c), c), R(NAN));
}

}  // namespace simplexseg
