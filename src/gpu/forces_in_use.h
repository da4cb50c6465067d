// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>

#include "forces/force_list.h"

namespace simplexseg {

/// Forces that are compiled in: all, except in benchmarks which show that an unused force costs nothing
/// (tests/benchmarks).
#ifdef SIMPLEXSEG_BUILT_FORCES
inline constexpr unsigned kBuiltForces = SIMPLEXSEG_BUILT_FORCES;
#else
inline constexpr unsigned kBuiltForces = (1u << kForceCount) - 1;
#endif

/// True if a kernel is compiled for every set of forces; that takes minutes under sanitizers and in the build with a
/// further force (tests/toy_force). Otherwise kernels contain all forces, with or without those that pull: a force that
/// is not in use has weight 0, and only pulling forces read their arrays nevertheless.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(SIMPLEXSEG_FEW_FORCE_SETS)
constexpr bool kEverySet = false;
#else
constexpr bool kEverySet = true;
#endif

/// Calls `run.operator()<forces>()` for the forces in use, a subset of kAmong. A kernel is compiled for each subset, so
/// it contains no code of unused forces; see kEverySet.
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
