// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>

#include "forces/force_list.h"

namespace simplexseg {

/// Set of the forces that are compiled in: all, except in the benchmarks that measure the cost of an unused force
/// (tests/benchmarks).
#ifdef SIMPLEXSEG_BUILT_FORCES
inline constexpr unsigned kBuiltForces = SIMPLEXSEG_BUILT_FORCES;
#else
inline constexpr unsigned kBuiltForces = (1u << kForceCount) - 1;
#endif

/// True if a kernel is compiled for every set of forces. False where this would take minutes: under sanitizers and with
/// an additional force (tests/toy_force). Kernels are then compiled for all forces, with and without the pulling ones:
/// an unused force has weight 0 and reads no arrays, except for pulling forces, which read their arrays in any case.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(SIMPLEXSEG_FEW_FORCE_SETS)
constexpr bool kEverySet = false;
#else
constexpr bool kEverySet = true;
#endif

/// Calls `run.operator()<forces>()` for the set `forces` in use, which must be a subset of kAmong. A kernel is compiled
/// for each subset, so that it contains no code of unused forces (unless kEverySet is false).
template <unsigned kAmong, unsigned kMask = kAmong, class Run>
void run_for(unsigned forces, Run&& run) {
  if constexpr (!kEverySet) {
    static_assert(std::has_single_bit(kPullingForces));
    if ((forces & kAmong & kPullingForces) != 0)
      run.template operator()<kAmong>();
    else
      run.template operator()<(kAmong & ~kPullingForces)>();
  } else if (forces == kMask) {
    run.template operator()<kMask>();
  } else if constexpr (kMask != 0) {
    run_for<kAmong, ((kMask - 1) & kAmong)>(forces, run);
  }
}

}  // namespace simplexseg
