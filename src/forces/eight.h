// SPDX-License-Identifier: Apache-2.0
// Vectorisation over eight vertices on the CPU. Called with an index of eight consecutive vertices, a kernel reads
// eight values, one into each lane of a vector register. Each lane performs the same operations as the code for one
// vertex, with bit-identical results (docs/adr/0025-eight-vertices-at-once.md). Include this header only in translation
// units compiled with AVX2, before the first kernel call with an Eight.
#pragma once
#include <immintrin.h>

#include "forces/lanes.h"
#include "forces/step_view.h"

namespace simplexseg {

inline constexpr int kEight = 8;

/// Eight Boolean values. All bits of a lane are set if its value is true.
struct Mask8 {
  __m256 bits;
  SIMPLEXSEG_HD friend Mask8 operator&(Mask8 a, Mask8 b) { return {_mm256_and_ps(a.bits, b.bits)}; }
  SIMPLEXSEG_HD friend Mask8 operator|(Mask8 a, Mask8 b) { return {_mm256_or_ps(a.bits, b.bits)}; }
  SIMPLEXSEG_HD friend Mask8 operator!(Mask8 a) {
    return {_mm256_xor_ps(a.bits, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))};
  }
  /// Bit mask of the lanes; bit k is lane k.
  SIMPLEXSEG_HD unsigned lanes() const { return static_cast<unsigned>(_mm256_movemask_ps(bits)); }
};
SIMPLEXSEG_HD bool any(Mask8 m) { return m.lanes() != 0; }
SIMPLEXSEG_HD bool all(Mask8 m) { return m.lanes() == 0xff; }

struct Float8 {
  __m256 lanes;
  Float8() = default;
  SIMPLEXSEG_HD Float8(float x) : lanes(_mm256_set1_ps(x)) {}
  SIMPLEXSEG_HD explicit Float8(__m256 x) : lanes(x) {}

  SIMPLEXSEG_HD friend Float8 operator+(Float8 a, Float8 b) { return Float8(_mm256_add_ps(a.lanes, b.lanes)); }
  SIMPLEXSEG_HD friend Float8 operator-(Float8 a, Float8 b) { return Float8(_mm256_sub_ps(a.lanes, b.lanes)); }
  SIMPLEXSEG_HD friend Float8 operator*(Float8 a, Float8 b) { return Float8(_mm256_mul_ps(a.lanes, b.lanes)); }
  SIMPLEXSEG_HD friend Float8 operator/(Float8 a, Float8 b) { return Float8(_mm256_div_ps(a.lanes, b.lanes)); }
  SIMPLEXSEG_HD friend Float8 operator-(Float8 a) { return Float8(_mm256_xor_ps(a.lanes, _mm256_set1_ps(-0.0f))); }
  SIMPLEXSEG_HD Float8& operator+=(Float8 a) { return *this = *this + a; }
  SIMPLEXSEG_HD Float8& operator-=(Float8 a) { return *this = *this - a; }
  SIMPLEXSEG_HD Float8& operator*=(Float8 a) { return *this = *this * a; }
  // Ordered comparisons: false if an operand is NaN.
  SIMPLEXSEG_HD friend Mask8 operator<(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LT_OQ)}; }
  SIMPLEXSEG_HD friend Mask8 operator<=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LE_OQ)}; }
  SIMPLEXSEG_HD friend Mask8 operator>(Float8 a, Float8 b) { return b < a; }
  SIMPLEXSEG_HD friend Mask8 operator>=(Float8 a, Float8 b) { return b <= a; }
  SIMPLEXSEG_HD friend Mask8 operator==(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_EQ_OQ)}; }

  // Counterparts of the functions for one float.
  SIMPLEXSEG_HD friend Float8 sqrtf(Float8 a) { return Float8(_mm256_sqrt_ps(a.lanes)); }
  SIMPLEXSEG_HD friend Float8 fabsf(Float8 a) { return Float8(_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.lanes)); }
  SIMPLEXSEG_HD friend Float8 powf(Float8 a, float power) {
    alignas(32) float x[kEight];
    _mm256_store_ps(x, a.lanes);
    for (float& one : x) one = ::powf(one, power);
    return Float8(_mm256_load_ps(x));
  }
};
// If either argument is NaN, the result is the second argument, as with the functions for one float.
SIMPLEXSEG_HD Float8 larger(Float8 a, Float8 b) { return Float8(_mm256_max_ps(a.lanes, b.lanes)); }
SIMPLEXSEG_HD Float8 smaller(Float8 a, Float8 b) { return Float8(_mm256_min_ps(a.lanes, b.lanes)); }
SIMPLEXSEG_HD Float8 choose(Mask8 first, Float8 a, Float8 b) {
  return Float8(_mm256_blendv_ps(b.lanes, a.lanes, first.bits));
}
SIMPLEXSEG_HD Float8 choose(bool first, Float8 a, Float8 b) { return first ? a : b; }

struct Integer8 {
  __m256i lanes;
};
template <>
struct LaneTypes<Float8> {
  using Integer = Integer8;
  using Boolean = Mask8;
};
SIMPLEXSEG_HD Integer8 to_integer(Float8 x) { return {_mm256_cvttps_epi32(x.lanes)}; }
SIMPLEXSEG_HD Float8 to_real(Integer8 x) { return Float8(_mm256_cvtepi32_ps(x.lanes)); }
SIMPLEXSEG_HD Integer8 smaller(Integer8 a, int b) { return {_mm256_min_epi32(a.lanes, _mm256_set1_epi32(b))}; }

/// Index of the vertices first ... first + 7.
struct Eight {
  int first;
  SIMPLEXSEG_HD int operator[](int lane) const { return first + lane; }
  SIMPLEXSEG_HD bool operator==(int i) const { return first == i; }
};
/// One neighbour of each of eight consecutive vertices. `first` points to that of the first vertex, in its Int4.
struct Neighbour8 {
  const int* first;
  SIMPLEXSEG_HD int operator[](int lane) const { return first[4 * lane]; }
};
struct Neighbours8 {
  Neighbour8 x, y, z;
  int w;  ///< mesh of all eight vertices; the executor never combines vertices of different meshes
};
SIMPLEXSEG_HD Neighbours8 load(const Int4* neighbours, Eight i) {
  const Int4* first = neighbours + i.first;
  return {{&first->x}, {&first->y}, {&first->z}, first->w};
}

template <>
struct RealOf<Eight> {
  using Type = Float8;
};

/// Reads values[i] for each lane of i.
SIMPLEXSEG_HD Float8 gather(const float* values, Integer8 i) {
  alignas(32) int at[kEight];
  _mm256_store_si256(reinterpret_cast<__m256i*>(at), i.lanes);
  auto x = [&](int lane) SIMPLEXSEG_INLINED { return values[at[lane]]; };
  return Float8(_mm256_set_ps(x(7), x(6), x(5), x(4), x(3), x(2), x(1), x(0)));
}
/// Loads eight texels and transposes them: the result has x of all eight, y of all eight, ...
template <class I>
SIMPLEXSEG_HD Vec4Of<Float8> load(const Vec4* texels, I i) {
  auto pair = [&](int lane) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(&texels[i[lane]].x)),
                                _mm_load_ps(&texels[i[lane + 4]].x), 1);
  };
  const __m256 a = pair(0), b = pair(1), c = pair(2), d = pair(3);
  const __m256 xy = _mm256_unpacklo_ps(a, b), zw = _mm256_unpackhi_ps(a, b), more_xy = _mm256_unpacklo_ps(c, d),
               more_zw = _mm256_unpackhi_ps(c, d);
  return {Float8(_mm256_shuffle_ps(xy, more_xy, 0x44)), Float8(_mm256_shuffle_ps(xy, more_xy, 0xee)),
          Float8(_mm256_shuffle_ps(zw, more_zw, 0x44)), Float8(_mm256_shuffle_ps(zw, more_zw, 0xee))};
}
template <class I>
SIMPLEXSEG_HD Float8 load_w(const Vec4* texels, I i) {
  auto w = [&](int lane) { return texels[i[lane]].w; };
  return Float8(_mm256_set_ps(w(7), w(6), w(5), w(4), w(3), w(2), w(1), w(0)));
}
SIMPLEXSEG_HD Float8 load(const float* values, Neighbour8 i) {
  auto x = [&](int lane) SIMPLEXSEG_INLINED { return values[i[lane]]; };
  return Float8(_mm256_set_ps(x(7), x(6), x(5), x(4), x(3), x(2), x(1), x(0)));
}
SIMPLEXSEG_HD Float8 load(const float* values, Eight i) { return Float8(_mm256_loadu_ps(values + i.first)); }
SIMPLEXSEG_HD void store(float* values, Eight i, Float8 x) { _mm256_storeu_ps(values + i.first, x.lanes); }
SIMPLEXSEG_HD void store(Vec4* texels, Eight i, Vec4Of<Float8> x) {
  const __m256 xy = _mm256_unpacklo_ps(x.x.lanes, x.y.lanes), more_xy = _mm256_unpackhi_ps(x.x.lanes, x.y.lanes);
  const __m256 zw = _mm256_unpacklo_ps(x.z.lanes, x.w.lanes), more_zw = _mm256_unpackhi_ps(x.z.lanes, x.w.lanes);
  const __m256 a = _mm256_shuffle_ps(xy, zw, 0x44), b = _mm256_shuffle_ps(xy, zw, 0xee),
               c = _mm256_shuffle_ps(more_xy, more_zw, 0x44), d = _mm256_shuffle_ps(more_xy, more_zw, 0xee);
  float* to = &texels[i.first].x;
  _mm256_storeu_ps(to, _mm256_permute2f128_ps(a, b, 0x20));
  _mm256_storeu_ps(to + 8, _mm256_permute2f128_ps(c, d, 0x20));
  _mm256_storeu_ps(to + 16, _mm256_permute2f128_ps(a, b, 0x31));
  _mm256_storeu_ps(to + 24, _mm256_permute2f128_ps(c, d, 0x31));
}
/// Eight floats in memory, for access to single lanes.
struct Floats8 {
  alignas(32) float values[kEight];
  SIMPLEXSEG_HD explicit Floats8(Float8 x) { _mm256_store_ps(values, x.lanes); }
  SIMPLEXSEG_HD Float8 pack() const { return Float8(_mm256_load_ps(values)); }
  SIMPLEXSEG_HD float& operator[](int lane) { return values[lane]; }
  SIMPLEXSEG_HD float operator[](int lane) const { return values[lane]; }
};
SIMPLEXSEG_HD void store_w(Vec4* texels, Eight i, Float8 w) {
  const Floats8 values(w);
  for (int k = 0; k < kEight; ++k) texels[i[k]].w = values[k];
}
struct Vectors8 {
  Floats8 x, y, z;
  SIMPLEXSEG_HD explicit Vectors8(Vec3Of<Float8> v) : x(v.x), y(v.y), z(v.z) {}
  SIMPLEXSEG_HD Vec3Of<Float8> pack() const { return {x.pack(), y.pack(), z.pack()}; }
  SIMPLEXSEG_HD Vec3 operator[](int lane) const { return {x[lane], y[lane], z[lane]}; }
  SIMPLEXSEG_HD void set(int lane, Vec3 v) { x[lane] = v.x, y[lane] = v.y, z[lane] = v.z; }
};
SIMPLEXSEG_HD Floats8 unpack_lanes(Float8 x) { return Floats8(x); }
SIMPLEXSEG_HD Vectors8 unpack_lanes(Vec3Of<Float8> v) { return Vectors8(v); }
SIMPLEXSEG_HD void add_to(float* parts, Float8 x) {
  _mm256_store_ps(parts, _mm256_add_ps(_mm256_load_ps(parts), x.lanes));
}
/// Lane argument of kernels that process eight vertices at once.
struct EightLanes : OneLane {
  static constexpr bool kEights = true, kStreams = true;
  using Index = Eight;
  using Serial = EightLanes;
  template <int kCapacity>
  struct Scratch {
    Float8 values[kCapacity];
    SIMPLEXSEG_HD Float8& operator[](int k) { return values[k]; }
  };
  template <int kCapacity>
  SIMPLEXSEG_HD Scratch<kCapacity> scratch(int /*first*/) const {
    Scratch<kCapacity> unset;
    return unset;
  }
};
/// Calls f(vertex, lane) for each vertex.
template <class F>
SIMPLEXSEG_HD void each(Eight i, F&& f) {
  for (int k = 0; k < kEight; ++k) f(i[k], k);
}
SIMPLEXSEG_HD bool is_set(Mask8 m, int lane) { return (m.lanes() >> lane & 1) != 0; }

}  // namespace simplexseg
