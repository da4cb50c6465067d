// SPDX-License-Identifier: Apache-2.0
// Common parts of the image forces: search for targets along the normal, displacement to a target.
#pragma once
#include "forces/sampling.h"
#include "forces/step_view.h"

namespace simplexseg {

inline constexpr int kMaxSearch = 24;  ///< largest number of samples or shifts to each side
inline constexpr int kMaxProfile = 8;  ///< largest half length of a reference profile, samples

/// Position, in [-1/2, 1/2], of the maximum of the parabola through (-1, a), (0, b), (1, c), where b >= a and b >= c.
template <class R>
SIMPLEXSEG_HD R parabolic_peak(R a, R b, R c) {
  const R curvature = a - 2.0f * b + c;
  const R t = 0.5f * (a - c) / curvature;
  return choose(curvature < 0.0f, smaller(larger(t, R(-0.5f)), R(0.5f)), R(0.0f));
}

/// Maximum of the values at shifts k = 0..2 reach. Ties go to the shift nearest to the middle, then to the lower one.
template <class R>
struct PeakOf {
  R best;
  R shift;        ///< signed distance of the maximum from the middle, k - reach
  R left, right;  ///< values at the adjacent shifts; NaN at the ends
  /// Signed distance of the peak from the middle, in shifts, with subsample accuracy.
  SIMPLEXSEG_HD R offset() const {
    return choose(is_valid(left) & is_valid(right), shift + parabolic_peak(left, best, right), shift);
  }
};
/// Rank of shift k by its distance from the middle shift, `reach`; of two equally distant shifts the lower comes first.
SIMPLEXSEG_HD int rank_of(int k, int reach) { return k <= reach ? 2 * (reach - k) : 2 * (k - reach) + 1; }

/// Peak of value(k), k = 0 ... 2 reach, ignoring NaN. Streaming lanes call value() once for each k, in order, and store
/// no values. Several lanes distribute the calls and store the values in `stored`. A single lane of the CPU that does
/// not stream also stores them, and searches them in passes that the compiler vectorises.
template <class L, class Stored, class Value>
SIMPLEXSEG_HD auto find_peak([[maybe_unused]] L lanes, [[maybe_unused]] Stored& stored, int reach, Value&& value) {
  using R = decltype(value(0));
  PeakOf<R> peak{-1e30f, 0.0f, NAN, NAN};
  if constexpr (L::kStreams) {
    R before = NAN, rank = 1e9f;
    BooleanOf<R> last_was_best = R(0.0f) > R(0.0f);
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
      stored[k] = x;
      const int own = rank_of(k, reach);
      if (x > peak.best || (x == peak.best && own < rank)) peak.best = x, rank = own;
    }
    for (int step = L::width / 2; step > 0; step /= 2) {
      const float best = lanes.shuffle_xor(peak.best, step);
      const int other = lanes.shuffle_xor(rank, step);
      if (best > peak.best || (best == peak.best && other < rank)) peak.best = best, rank = other;
    }
    lanes.sync();
    if (rank != 0x7fffffff) best_k = rank % 2 == 0 ? reach - rank / 2 : reach + rank / 2;
#else
    for (int k = 0; k <= 2 * reach; ++k) stored[k] = value(k);
    for (int k = 0; k <= 2 * reach; ++k) peak.best = larger(stored[k], peak.best);
    for (int j = 0; j <= reach; ++j) {
      if (stored[reach - j] == peak.best || stored[reach + j] == peak.best) {
        best_k = stored[reach - j] == peak.best ? reach - j : reach + j;
        break;
      }
    }
#endif
    peak.shift = static_cast<float>(best_k - reach);
    if (best_k > 0) peak.left = stored[best_k - 1];
    if (best_k < 2 * reach) peak.right = stored[best_k + 1];
    return peak;
  }
}

/// Displacement of a vertex at p towards its target, mm: the distance of the target along the current normal n, limited
/// to `pull_mm` if that is > 0, times the confidence. Only the normal component counts, so that vertices can slide on
/// the surface.
template <class R>
SIMPLEXSEG_HD Vec3Of<R> pull_to_target(Vec4Of<R> target, Vec3Of<R> p, Vec3Of<R> n, float pull_mm) {
  R d = dot(xyz(target) - p, n);
  if (pull_mm > 0.0f) d = smaller(larger(d, R(-pull_mm)), R(pull_mm));
  return (target.w * d) * n;
}

}  // namespace simplexseg
