// SPDX-License-Identifier: Apache-2.0
// What the image forces share: targets along the normal, and how they pull.
#pragma once
#include "forces/sampling.h"
#include "forces/step_view.h"

namespace simplexseg {

inline constexpr int kMaxSearch = 24;  ///< samples to each side
inline constexpr int kMaxProfile = 8;  ///< half length of a reference profile

/// Offset of the extremum of a parabola through (-1, a), (0, b), (1, c), b the largest; in [-1/2, 1/2].
template <class R>
SIMPLEXSEG_HD R parabolic_peak(R a, R b, R c) {
  const R curvature = a - 2.0f * b + c;
  const R t = 0.5f * (a - c) / curvature;
  return choose(curvature < 0.0f, smaller(larger(t, R(-0.5f)), R(0.5f)), R(0.0f));
}

/// The largest of the values at shifts k = 0..2 reach: of equal ones the nearest to the middle, of two as near the
/// lower.
template <class R>
struct PeakOf {
  R best;
  R shift;        ///< from the middle: k - reach
  R left, right;  ///< values beside it; NaN where there is none
  /// Its place from the middle, to a fraction of a shift.
  SIMPLEXSEG_HD R offset() const {
    return choose(is_valid(left) & is_valid(right), shift + parabolic_peak(left, best, right), shift);
  }
};
/// How near a shift is to the middle: less is nearer; of two as near the lower one is less.
SIMPLEXSEG_HD int rank_of(int k, int reach) { return k <= reach ? 2 * (reach - k) : 2 * (k - reach) + 1; }

/// The peak of value(k), k = 0 ... 2 reach; NaN is no value. Lanes that stream call it once for each k, in order, and
/// keep none; several lanes share the calls out and keep the values in `kept`; one lane of the CPU does so in passes
/// that the compiler vectorises.
template <class L, class Kept, class Value>
SIMPLEXSEG_HD auto find_peak([[maybe_unused]] L lanes, [[maybe_unused]] Kept& kept, int reach, Value&& value) {
  using R = decltype(value(0));
  PeakOf<R> peak{-1e30f, 0.0f, NAN, NAN};
  if constexpr (L::kStreams) {
    R before = NAN, rank = 1e9f;
    Answer<R> last_was_best = R(0.0f) > R(0.0f);
    SIMPLEXSEG_UNROLL
    for (int k = 0; k <= 2 * reach; ++k) {
      const R x = value(k);
      peak.right = choose(last_was_best, x, peak.right);
      const float own = static_cast<float>(rank_of(k, reach));
      last_was_best = (x > peak.best) | ((x == peak.best) & (own < rank));
      peak = {choose(last_was_best, x, peak.best), choose(last_was_best, R(static_cast<float>(k - reach)), peak.shift),
              choose(last_was_best, before, peak.left), choose(last_was_best, R(NAN), peak.right)};
      rank = choose(last_was_best, R(own), rank);
      before = x;
    }
    return peak;
  } else {
    int best_k = reach;
#ifdef __CUDA_ARCH__
    int rank = 0x7fffffff;
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
    if (rank != 0x7fffffff) best_k = rank % 2 == 0 ? reach - rank / 2 : reach + rank / 2;
#else
    for (int k = 0; k <= 2 * reach; ++k) kept[k] = value(k);
    for (int k = 0; k <= 2 * reach; ++k) peak.best = larger(kept[k], peak.best);
    for (int j = 0; j <= reach; ++j) {
      if (kept[reach - j] == peak.best || kept[reach + j] == peak.best) {
        best_k = kept[reach - j] == peak.best ? reach - j : reach + j;
        break;
      }
    }
#endif
    peak.shift = static_cast<float>(best_k - reach);
    if (best_k > 0) peak.left = kept[best_k - 1];
    if (best_k < 2 * reach) peak.right = kept[best_k + 1];
    return peak;
  }
}

/// The force of a target kept since the last refresh: its distance along the present normal, so that a vertex is free
/// to slide on the surface. `pull_mm` > 0 bounds it.
template <class R>
SIMPLEXSEG_HD Vec3Of<R> pull_to_target(Vec4Of<R> target, Vec3Of<R> p, Vec3Of<R> n, float pull_mm) {
  R d = dot(xyz(target) - p, n);
  if (pull_mm > 0.0f) d = smaller(larger(d, R(-pull_mm)), R(pull_mm));
  return (target.w * d) * n;
}

}  // namespace simplexseg
