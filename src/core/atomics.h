// SPDX-License-Identifier: Apache-2.0
// Integer atomics for both backends. Integer sums do not depend on the order of the operations.
#pragma once
#include <cstring>

#include "core/vec3.h"

namespace simplexseg {

SIMPLEXSEG_HD void atomic_min(unsigned long long* at, unsigned long long value) {
#ifdef __CUDA_ARCH__
  atomicMin(at, value);
#else
  unsigned long long now = __atomic_load_n(at, __ATOMIC_RELAXED);
  while (value < now && !__atomic_compare_exchange_n(at, &now, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
#endif
}
SIMPLEXSEG_HD void atomic_add(long long* at, long long value) {
#ifdef __CUDA_ARCH__
  atomicAdd(reinterpret_cast<unsigned long long*>(at), static_cast<unsigned long long>(value));
#else
  __atomic_fetch_add(at, value, __ATOMIC_RELAXED);
#endif
}
/// Adds `value` and returns the previous value.
SIMPLEXSEG_HD unsigned atomic_add(unsigned* at, int value) {
#ifdef __CUDA_ARCH__
  return atomicAdd(at, static_cast<unsigned>(value));
#else
  return __atomic_fetch_add(at, static_cast<unsigned>(value), __ATOMIC_RELAXED);
#endif
}
SIMPLEXSEG_HD int atomic_add(int* at, int value) {
#ifdef __CUDA_ARCH__
  return atomicAdd(at, value);
#else
  return __atomic_fetch_add(at, value, __ATOMIC_RELAXED);
#endif
}
/// Stores the minimum (atomic_max(): the maximum) of the stored value and `value`; returns the previous value.
SIMPLEXSEG_HD int atomic_min(int* at, int value) {
#ifdef __CUDA_ARCH__
  return atomicMin(at, value);
#else
  int now = __atomic_load_n(at, __ATOMIC_RELAXED);
  while (value < now && !__atomic_compare_exchange_n(at, &now, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
  return now;
#endif
}
SIMPLEXSEG_HD int atomic_max(int* at, int value) {
#ifdef __CUDA_ARCH__
  return atomicMax(at, value);
#else
  int now = __atomic_load_n(at, __ATOMIC_RELAXED);
  while (value > now && !__atomic_compare_exchange_n(at, &now, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
  return now;
#endif
}
/// Reads a value that other threads may be changing, without memory ordering.
SIMPLEXSEG_HD unsigned long long load_relaxed(const unsigned long long* at) {
#ifdef __CUDA_ARCH__
  return *const_cast<const volatile unsigned long long*>(at);
#else
  return __atomic_load_n(at, __ATOMIC_RELAXED);
#endif
}
SIMPLEXSEG_HD int load_relaxed(const int* at) {
#ifdef __CUDA_ARCH__
  return *const_cast<const volatile int*>(at);
#else
  return __atomic_load_n(at, __ATOMIC_RELAXED);
#endif
}
SIMPLEXSEG_HD float load_relaxed(const float* at) {
#ifdef __CUDA_ARCH__
  return *at;
#else
  float x;
  __atomic_load(at, &x, __ATOMIC_RELAXED);
  return x;
#endif
}
/// Writes a value that other threads may be reading, without memory ordering.
SIMPLEXSEG_HD void store_relaxed(float* at, float value) {
#ifdef __CUDA_ARCH__
  *at = value;
#else
  __atomic_store(at, &value, __ATOMIC_RELAXED);
#endif
}
SIMPLEXSEG_HD void store_relaxed(int* at, int value) {
#ifdef __CUDA_ARCH__
  *at = value;
#else
  __atomic_store_n(at, value, __ATOMIC_RELAXED);
#endif
}
/// Writes a flag that several threads may set to the same value at once.
SIMPLEXSEG_HD void store_relaxed(unsigned char* at, unsigned char value) {
#ifdef __CUDA_ARCH__
  *at = value;
#else
  __atomic_store_n(at, value, __ATOMIC_RELAXED);
#endif
}
/// Bits of a float. The bits of floats >= 0 are ordered like the floats.
SIMPLEXSEG_HD unsigned bits_of(float x) {
#ifdef __CUDA_ARCH__
  return __float_as_uint(x);
#else
  unsigned u;
  std::memcpy(&u, &x, sizeof u);
  return u;
#endif
}
/// Float with these bits; inverse of bits_of().
SIMPLEXSEG_HD float float_of(unsigned u) {
#ifdef __CUDA_ARCH__
  return __uint_as_float(u);
#else
  float x;
  std::memcpy(&x, &u, sizeof x);
  return x;
#endif
}

}  // namespace simplexseg
