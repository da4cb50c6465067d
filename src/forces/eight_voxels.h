// SPDX-License-Identifier: Apache-2.0
// Reads the voxels of eight cells, each as four pairs of adjacent voxels. Gather instructions are not used: they do not
// support voxels of 8 and 16 bits, and they would also perform one load per voxel.
#pragma once
#include <cstring>

#include "forces/eight.h"
#include "forces/sampling.h"

namespace simplexseg {

struct Pairs8 {
  Float8 first, second;
};
/// Reads a pair of adjacent voxels at each of eight addresses plus `offset` (voxels), as floats.
template <class T>
SIMPLEXSEG_HD Pairs8 pairs_at(const T* const* at, long offset) {
  if constexpr (sizeof(T) <= 2) {
    auto pair = [&](int lane) SIMPLEXSEG_INLINED {
      std::conditional_t<sizeof(T) == 2, std::uint32_t, std::uint16_t> bits;
      std::memcpy(&bits, at[lane] + offset, sizeof bits);
      return static_cast<int>(bits);
    };
    constexpr int kBits = 8 * sizeof(T), kShift = 32 - kBits;
    const __m256i x = _mm256_set_epi32(pair(7), pair(6), pair(5), pair(4), pair(3), pair(2), pair(1), pair(0));
    const __m256i low = _mm256_slli_epi32(x, kShift), high = _mm256_slli_epi32(x, kShift - kBits);
    auto to_float = [](__m256i bits) SIMPLEXSEG_INLINED {
      return Float8(
          _mm256_cvtepi32_ps(std::is_signed_v<T> ? _mm256_srai_epi32(bits, kShift) : _mm256_srli_epi32(bits, kShift)));
    };
    return {to_float(low), to_float(high)};
  } else {
    // Pair [x0 x1] of a lane, as floats or, for integer voxels, as their bits.
    auto pair = [&](int lane) SIMPLEXSEG_INLINED {
      if constexpr (std::is_same_v<T, double>)
        return _mm_castps_pd(_mm_cvtpd_ps(_mm_loadu_pd(at[lane] + offset)));
      else
        return _mm_castsi128_pd(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(at[lane] + offset)));
    };
    auto four = [&](int a, int b) SIMPLEXSEG_INLINED {
      const __m128d low = _mm_unpacklo_pd(pair(a), pair(a + 1)), high = _mm_unpacklo_pd(pair(b), pair(b + 1));
      return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_castpd_ps(low)), _mm_castpd_ps(high), 1);
    };
    const __m256 a = four(0, 4), b = four(2, 6);
    auto to_float = [](__m256 bits) SIMPLEXSEG_INLINED {
      return Float8(std::is_integral_v<T> ? _mm256_cvtepi32_ps(_mm256_castps_si256(bits)) : bits);
    };
    return {to_float(_mm256_shuffle_ps(a, b, 0x88)), to_float(_mm256_shuffle_ps(a, b, 0xdd))};
  }
}

template <class T>
SIMPLEXSEG_HD CornersOf<Float8> corners_of(const LinearVoxels<T>& read, const CellOf<Float8>& c) {
  // Row indices have 32 bits and voxel offsets 64. `offset` has those of lanes 0, 2, 4, 6 first, then 1, 3, 5, 7.
  const __m256i rows = _mm256_add_epi32(
      _mm256_mullo_epi32(c.k.lanes, _mm256_set1_epi32(static_cast<int>(read.plane / read.row))), c.j.lanes);
  const __m256i length = _mm256_set1_epi32(static_cast<int>(read.row));
  auto offsets = [&](__m256i row, __m256i i) SIMPLEXSEG_INLINED {
    return _mm256_add_epi64(_mm256_mul_epu32(row, length), _mm256_and_si256(i, _mm256_set1_epi64x(0xffffffff)));
  };
  alignas(32) long offset[kEight];
  _mm256_store_si256(reinterpret_cast<__m256i*>(offset), offsets(rows, c.i.lanes));
  _mm256_store_si256(reinterpret_cast<__m256i*>(offset + 4),
                     offsets(_mm256_srli_epi64(rows, 32), _mm256_srli_epi64(c.i.lanes, 32)));
  const T* at[kEight];
  for (int lane = 0; lane < kEight; ++lane) at[lane] = read.voxels + offset[lane % 2 * 4 + lane / 2];
  // Reads single voxels if the volume has only one along i, and for uint32, which cannot be converted as int.
  if (read.dx == 0 || std::is_same_v<T, std::uint32_t>) {
    auto all = [&](long offset) SIMPLEXSEG_INLINED {
      alignas(32) float x[kEight];
      for (int lane = 0; lane < kEight; ++lane) x[lane] = static_cast<float>(at[lane][offset]);
      return Float8(_mm256_load_ps(x));
    };
    const long x = read.dx, y = read.dy, z = read.dz;
    return {all(0), all(x), all(y), all(y + x), all(z), all(z + x), all(z + y), all(z + y + x)};
  }
  const Pairs8 a = pairs_at(at, 0), b = pairs_at(at, read.dy), d = pairs_at(at, read.dz),
               e = pairs_at(at, read.dy + read.dz);
  return {a.first, a.second, b.first, b.second, d.first, d.second, e.first, e.second};
}

}  // namespace simplexseg
