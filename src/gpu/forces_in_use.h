// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/force_list.h"

namespace simplexseg {

/// The forces that are in the program. Fewer only to measure that one which is not used costs nothing
/// (tests/benchmarks).
#ifdef SIMPLEXSEG_BUILT_FORCES
inline constexpr unsigned kBuiltForces = SIMPLEXSEG_BUILT_FORCES;
#else
inline constexpr unsigned kBuiltForces = (1u << kForceCount) - 1;
#endif

/// `run.operator()<forces>()` for the set of forces that are in use, which is one of the subsets of kAmong: a kernel is
/// compiled for each of them, so that what no mesh uses is not in its code.
template <unsigned kAmong, unsigned kMask = kAmong, class Run>
void run_for(unsigned forces, Run&& run) {
  if (forces == kMask)
    run.template operator()<kMask>();
  else if constexpr (kMask != 0)
    run_for<kAmong, ((kMask - 1) & kAmong)>(forces, run);
}

}  // namespace simplexseg
