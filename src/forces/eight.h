// SPDX-License-Identifier: Apache-2.0
// Eight vertices at once, on the CPU: an index that stands for eight vertices in a row gives eight of all that a kernel
// reads with it, one in each lane of a vector register. A lane's arithmetic is that of one vertex by itself, operation
// by operation, so that the bits are too (docs/adr/0025-eight-vertices-at-once.md). Only for units that are compiled
// with AVX2, and included there before any kernel is called with an Eight.
#pragma once
#include <immintrin.h>

#include "forces/lanes.h"
#include "forces/step_view.h"

namespace simplexseg {

inline constexpr int kEight = 8;

/// Eight answers: all bits of a lane are set where it is true.
struct Mask8 {
  __m256 bits;
  SIMPLEXSEG_HD friend Mask8 operator&(Mask8 a, Mask8 b) { return {_mm256_and_ps(a.bits, b.bits)}; }
  SIMPLEXSEG_HD friend Mask8 operator|(Mask8 a, Mask8 b) { return {_mm256_or_ps(a.bits, b.bits)}; }
  SIMPLEXSEG_HD friend Mask8 operator!(Mask8 a) {
    return {_mm256_xor_ps(a.bits, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))};
  }
  /// Bit k: lane k.
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
  // Ordered: false where a number is NaN.
  SIMPLEXSEG_HD friend Mask8 operator<(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LT_OQ)}; }
  SIMPLEXSEG_HD friend Mask8 operator<=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LE_OQ)}; }
  SIMPLEXSEG_HD friend Mask8 operator>(Float8 a, Float8 b) { return b < a; }
  SIMPLEXSEG_HD friend Mask8 operator>=(Float8 a, Float8 b) { return b <= a; }
  SIMPLEXSEG_HD friend Mask8 operator==(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_EQ_OQ)}; }

  // As those of one float, which are found beside these.
  SIMPLEXSEG_HD friend Float8 sqrtf(Float8 a) { return Float8(_mm256_sqrt_ps(a.lanes)); }
  SIMPLEXSEG_HD friend Float8 fabsf(Float8 a) { return Float8(_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.lanes)); }
  SIMPLEXSEG_HD friend Float8 powf(Float8 a, float power) {
    alignas(32) float x[kEight];
    _mm256_store_ps(x, a.lanes);
    for (float& one : x) one = ::powf(one, power);
    return Float8(_mm256_load_ps(x));
  }
};
// The instructions give the second argument where one is NaN, as the comparisons of one float do.
SIMPLEXSEG_HD Float8 larger(Float8 a, Float8 b) { return Float8(_mm256_max_ps(a.lanes, b.lanes)); }
SIMPLEXSEG_HD Float8 smaller(Float8 a, Float8 b) { return Float8(_mm256_min_ps(a.lanes, b.lanes)); }
SIMPLEXSEG_HD Float8 choose(Mask8 first, Float8 a, Float8 b) {
  return Float8(_mm256_blendv_ps(b.lanes, a.lanes, first.bits));
}
SIMPLEXSEG_HD Float8 choose(bool first, Float8 a, Float8 b) { return first ? a : b; }

struct Whole8 {
  __m256i lanes;
};
template <>
struct With<Float8> {
  using Whole = Whole8;
  using Answer = Mask8;
};
SIMPLEXSEG_HD Whole8 whole_of(Float8 x) { return {_mm256_cvttps_epi32(x.lanes)}; }
SIMPLEXSEG_HD Float8 real_of(Whole8 x) { return Float8(_mm256_cvtepi32_ps(x.lanes)); }
SIMPLEXSEG_HD Whole8 smaller(Whole8 a, int b) { return {_mm256_min_epi32(a.lanes, _mm256_set1_epi32(b))}; }

/// Vertices first ... first + 7.
struct Eight {
  int first;
  SIMPLEXSEG_HD int operator[](int lane) const { return first + lane; }
  SIMPLEXSEG_HD bool operator==(int i) const { return first == i; }
};
/// A neighbour of each of eight vertices in a row: a member of the first one's Int4.
struct Beside8 {
  const int* first;
  SIMPLEXSEG_HD int operator[](int lane) const { return first[4 * lane]; }
};
struct Neighbours8 {
  Beside8 x, y, z;
  int w;  ///< of all eight: the executor sees to it
};
SIMPLEXSEG_HD Neighbours8 load(const Int4* neighbours, Eight i) {
  const Int4* of = neighbours + i.first;
  return {{&of->x}, {&of->y}, {&of->z}, of->w};
}

template <>
struct RealOf<Eight> {
  using Type = Float8;
};

/// values[i] of each.
SIMPLEXSEG_HD Float8 look_up(const float* values, Whole8 i) {
  alignas(32) int at[kEight];
  _mm256_store_si256(reinterpret_cast<__m256i*>(at), i.lanes);
  auto x = [&](int lane) SIMPLEXSEG_INLINED { return values[at[lane]]; };
  return Float8(_mm256_set_ps(x(7), x(6), x(5), x(4), x(3), x(2), x(1), x(0)));
}
/// Texels, read one by one and turned: x of all eight, y of all eight ...
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
SIMPLEXSEG_HD Float8 load(const float* values, Beside8 i) {
  auto x = [&](int lane) SIMPLEXSEG_INLINED { return values[i[lane]]; };
  return Float8(_mm256_set_ps(x(7), x(6), x(5), x(4), x(3), x(2), x(1), x(0)));
}
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
/// One float for each of eight, to be worked on one by one.
struct Floats8 {
  alignas(32) float values[kEight];
  SIMPLEXSEG_HD explicit Floats8(Float8 x) { _mm256_store_ps(values, x.lanes); }
  SIMPLEXSEG_HD Float8 together() const { return Float8(_mm256_load_ps(values)); }
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
  SIMPLEXSEG_HD Vec3Of<Float8> together() const { return {x.together(), y.together(), z.together()}; }
  SIMPLEXSEG_HD Vec3 operator[](int lane) const { return {x[lane], y[lane], z[lane]}; }
  SIMPLEXSEG_HD void set(int lane, Vec3 v) { x[lane] = v.x, y[lane] = v.y, z[lane] = v.z; }
};
SIMPLEXSEG_HD Floats8 one_by_one(Float8 x) { return Floats8(x); }
SIMPLEXSEG_HD Vectors8 one_by_one(Vec3Of<Float8> v) { return Vectors8(v); }
SIMPLEXSEG_HD void add_to(float* parts, Float8 x) {
  _mm256_store_ps(parts, _mm256_add_ps(_mm256_load_ps(parts), x.lanes));
}
/// What a kernel that is written for lanes is called with, where it may take eight vertices at once.
struct EightLanes : OneLane {
  static constexpr bool kEights = true, kStreams = true;
  using Index = Eight;
  using Alone = EightLanes;
  template <int kMost>
  struct Scratch {
    Float8 values[kMost];
    SIMPLEXSEG_HD Float8& operator[](int k) { return values[k]; }
  };
  template <int kMost>
  SIMPLEXSEG_HD Scratch<kMost> scratch(int /*first*/) const {
    Scratch<kMost> unset;
    return unset;
  }
};
/// f(vertex, lane) for each.
template <class F>
SIMPLEXSEG_HD void each(Eight i, F&& f) {
  for (int k = 0; k < kEight; ++k) f(i[k], k);
}
SIMPLEXSEG_HD bool is_set(Mask8 m, int lane) { return (m.lanes() >> lane & 1) != 0; }

}  // namespace simplexseg
