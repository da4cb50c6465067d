// SPDX-License-Identifier: Apache-2.0
// Vector types of the kernels. They are plain aggregates instead of Eigen types: a texel is read by one 16-byte load,
// and the compilers of both backends vectorise code with them (docs/adr/0002-kernel-types.md). Host code uses Eigen.
#pragma once
#include <cmath>
#include <type_traits>

#ifdef __CUDACC__
#define SIMPLEXSEG_HD __host__ __device__ __forceinline__
#define SIMPLEXSEG_UNROLL _Pragma("unroll 4")  // groups the loads of four iterations; no pragma for the CPU compiler
#define SIMPLEXSEG_INLINED
#else
#define SIMPLEXSEG_UNROLL
#define SIMPLEXSEG_HD inline __attribute__((always_inline))
#define SIMPLEXSEG_INLINED __attribute__((always_inline))  // written after the parameters of a lambda
#endif

namespace simplexseg {

/// Vector. `R`: float, or a vector register with one value for each of eight vertices (forces/eight.h).
template <class R>
struct Vec3Of {
  R x, y, z;
};
/// Texel: a vector and a fourth value.
template <class R>
struct alignas(alignof(R) > 4 ? alignof(R) : 16) Vec4Of {
  R x, y, z, w;
};
using Vec3 = Vec3Of<float>;
using Vec4 = Vec4Of<float>;
struct alignas(16) Int4 {
  int x, y, z, w;
};

// Single instructions, unlike fmaxf and fminf of the C library. If either argument is NaN, the result is the second
// one.
SIMPLEXSEG_HD float larger(float a, float b) { return a > b ? a : b; }
SIMPLEXSEG_HD float smaller(float a, float b) { return a < b ? a : b; }

SIMPLEXSEG_HD float inverse_sqrt(float x) {
#ifdef __CUDA_ARCH__
  return rsqrtf(x);
#else
  return 1.0f / sqrtf(x);
#endif
}

template <class R>
SIMPLEXSEG_HD Vec3Of<R> operator+(Vec3Of<R> a, Vec3Of<R> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class R>
SIMPLEXSEG_HD Vec3Of<R> operator-(Vec3Of<R> a, Vec3Of<R> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class R>
SIMPLEXSEG_HD Vec3Of<R> operator*(std::type_identity_t<R> s, Vec3Of<R> a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class R>
SIMPLEXSEG_HD R dot(Vec3Of<R> a, Vec3Of<R> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class R>
SIMPLEXSEG_HD Vec3Of<R> cross(Vec3Of<R> a, Vec3Of<R> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class R>
SIMPLEXSEG_HD R norm(Vec3Of<R> a) {
  return sqrtf(dot(a, a));
}
template <class R>
SIMPLEXSEG_HD Vec3Of<R> xyz(Vec4Of<R> a) {
  return {a.x, a.y, a.z};
}
template <class R>
SIMPLEXSEG_HD Vec4Of<R> with_w(Vec3Of<R> a, std::type_identity_t<R> w) {
  return {a.x, a.y, a.z, w};
}

// Branch-free selection of `a` where `first` is true, else `b`. With eight vertices at once, each lane selects
// separately.
SIMPLEXSEG_HD float choose(bool first, float a, float b) { return first ? a : b; }
template <class Condition, class R>
SIMPLEXSEG_HD Vec3Of<R> choose(Condition first, Vec3Of<R> a, Vec3Of<R> b) {
  return {choose(first, a.x, b.x), choose(first, a.y, b.y), choose(first, a.z, b.z)};
}
/// Integer and Boolean types with as many lanes as R.
template <class R>
struct LaneTypes {
  using Integer = int;
  using Boolean = bool;
};
template <class R>
using IntegerOf = typename LaneTypes<R>::Integer;
template <class R>
using BooleanOf = typename LaneTypes<R>::Boolean;
SIMPLEXSEG_HD int to_integer(float x) { return static_cast<int>(x); }  ///< rounds towards 0
SIMPLEXSEG_HD float to_real(int x) { return static_cast<float>(x); }
SIMPLEXSEG_HD int smaller(int a, int b) { return a < b ? a : b; }
SIMPLEXSEG_HD int larger(int a, int b) { return a > b ? a : b; }
SIMPLEXSEG_HD bool any(bool x) { return x; }
SIMPLEXSEG_HD bool all(bool x) { return x; }

}  // namespace simplexseg
