// SPDX-License-Identifier: Apache-2.0
// The two vector types of the kernels. They are plain aggregates, not Eigen's: one 16-byte load a texel, and what the
// compilers of both backends vectorise (docs/adr/0002-kernel-types.md). Host code uses Eigen.
#pragma once
#include <cmath>

#ifdef __CUDACC__
#define SIMPLEXSEG_HD __host__ __device__ __forceinline__
#define SIMPLEXSEG_UNROLL _Pragma("unroll 4")  // loads of four rounds at once; the CPU's compiler knows better
#else
#define SIMPLEXSEG_UNROLL
#define SIMPLEXSEG_HD inline __attribute__((always_inline))
#endif

namespace simplexseg {

struct Vec3 {
  float x, y, z;
};
/// One texel: a vector and a fourth value that travels with it.
struct alignas(16) Vec4 {
  float x, y, z, w;
};
struct alignas(16) Int4 {
  int x, y, z, w;
};

// One instruction each, where fmaxf and fminf of the C library are calls. A first argument that is NaN gives the
// second.
SIMPLEXSEG_HD float larger(float a, float b) { return a > b ? a : b; }
SIMPLEXSEG_HD float smaller(float a, float b) { return a < b ? a : b; }

SIMPLEXSEG_HD float inverse_sqrt(float x) {
#ifdef __CUDA_ARCH__
  return rsqrtf(x);
#else
  return 1.0f / sqrtf(x);
#endif
}

SIMPLEXSEG_HD Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
SIMPLEXSEG_HD Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
SIMPLEXSEG_HD Vec3 operator*(float s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
SIMPLEXSEG_HD float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SIMPLEXSEG_HD Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
SIMPLEXSEG_HD float norm(Vec3 a) { return sqrtf(dot(a, a)); }
SIMPLEXSEG_HD Vec3 xyz(Vec4 a) { return {a.x, a.y, a.z}; }
SIMPLEXSEG_HD Vec4 with_w(Vec3 a, float w) { return {a.x, a.y, a.z, w}; }

}  // namespace simplexseg
