// SPDX-License-Identifier: Apache-2.0
// What the image forces share: targets along the normal, and how they pull.
#pragma once
#include "forces/sampling.h"
#include "forces/step_view.h"

namespace simplexseg {

inline constexpr int kMaxSearch = 24;  ///< samples to each side
inline constexpr int kMaxProfile = 8;  ///< half length of a reference profile

/// Offset of the extremum of a parabola through (-1, a), (0, b), (1, c), b the largest; in [-1/2, 1/2].
SIMPLEXSEG_HD float parabolic_peak(float a, float b, float c) {
  const float curvature = a - 2.0f * b + c;
  if (!(curvature < 0.0f)) return 0.0f;
  const float t = 0.5f * (a - c) / curvature;
  return smaller(larger(t, -0.5f), 0.5f);
}

/// The largest of the values at shifts k = 0..2 reach: of equal ones the nearest to the middle, of two as near the
/// lower.
struct Peak {
  float best;
  int k;
  float left, right;  ///< values beside it; NaN where there is none
  /// Its place from the middle, to a fraction of a shift.
  SIMPLEXSEG_HD float offset(int reach) const {
    const float whole = static_cast<float>(k - reach);
    return is_valid(left) && is_valid(right) ? whole + parabolic_peak(left, best, right) : whole;
  }
};
/// How near a shift is to the middle: less is nearer; of two as near the lower one is less.
SIMPLEXSEG_HD int rank_of(int k, int reach) { return k <= reach ? 2 * (reach - k) : 2 * (k - reach) + 1; }

/// The peak of value(k), k = 0 ... 2 reach; NaN is no value. One device thread calls it once for each k, in order, and
/// keeps none; several lanes share the calls out and keep the values in `kept`; the CPU does so in passes that the
/// compiler vectorises.
template <class L, class Kept, class Value>
SIMPLEXSEG_HD Peak find_peak([[maybe_unused]] L lanes, [[maybe_unused]] Kept& kept, int reach, Value&& value) {
  Peak peak{-1e30f, reach, NAN, NAN};
#ifdef __CUDA_ARCH__
  int rank = 0x7fffffff;
  if constexpr (L::width == 1) {
    float before = NAN;
    bool last_was_best = false;
    SIMPLEXSEG_UNROLL
    for (int k = 0; k <= 2 * reach; ++k) {
      const float x = value(k);
      if (last_was_best) peak.right = x;
      const int own = rank_of(k, reach);
      last_was_best = x > peak.best || (x == peak.best && own < rank);
      if (last_was_best) peak = {x, k, before, NAN}, rank = own;
      before = x;
    }
    return peak;
  } else {
    for (int k = lanes.lane; k <= 2 * reach; k += L::width) {
      const float x = value(k);
      kept[k] = x;
      const int own = rank_of(k, reach);
      if (x > peak.best || (x == peak.best && own < rank)) peak.best = x, rank = own;
    }
    for (int step = L::width / 2; step > 0; step /= 2) {
      const float best = lanes.from_lane_across(peak.best, step);
      const int other = lanes.from_lane_across(rank, step);
      if (best > peak.best || (best == peak.best && other < rank)) peak.best = best, rank = other;
    }
    lanes.sync();
    if (rank != 0x7fffffff) peak.k = rank % 2 == 0 ? reach - rank / 2 : reach + rank / 2;
  }
#else
  for (int k = 0; k <= 2 * reach; ++k) kept[k] = value(k);
  for (int k = 0; k <= 2 * reach; ++k) peak.best = larger(kept[k], peak.best);
  for (int j = 0; j <= reach; ++j) {
    if (kept[reach - j] == peak.best || kept[reach + j] == peak.best) {
      peak.k = kept[reach - j] == peak.best ? reach - j : reach + j;
      break;
    }
  }
#endif
  if (peak.k > 0) peak.left = kept[peak.k - 1];
  if (peak.k < 2 * reach) peak.right = kept[peak.k + 1];
  return peak;
}

/// The force of a target kept since the last refresh: its distance along the present normal, so that a vertex is free
/// to slide on the surface. `pull_mm` > 0 bounds it.
SIMPLEXSEG_HD Vec3 pull_to_target(Vec4 target, Vec3 p, Vec3 n, float pull_mm) {
  float d = dot(xyz(target) - p, n);
  if (pull_mm > 0.0f) d = smaller(larger(d, -pull_mm), pull_mm);
  return (target.w * d) * n;
}

}  // namespace simplexseg
