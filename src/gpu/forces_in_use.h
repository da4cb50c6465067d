// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/force_list.h"
#include "forces/step_view.h"

namespace simplexseg {

/// Set of the forces that are compiled in: all, except in the benchmarks that measure the cost of an unused force
/// (tests/benchmarks).
#ifdef SIMPLEXSEG_BUILT_FORCES
inline constexpr unsigned kBuiltForces = SIMPLEXSEG_BUILT_FORCES;
#else
inline constexpr unsigned kBuiltForces = (1u << kForceCount) - 1;
#endif

/// True if a kernel is compiled for every set of forces. False where this would take minutes: under sanitizers and with
/// an additional force (tests/toy_force). One kernel then contains all forces, and in_use() selects them at run time.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(SIMPLEXSEG_FEW_FORCE_SETS)
constexpr bool kEverySet = false;
#else
constexpr bool kEverySet = true;
#endif

/// True if force F acts on some mesh; only then are its arrays allocated. Always true if kEverySet: a kernel then
/// contains only the forces in use.
template <class F>
SIMPLEXSEG_HD constexpr bool in_use(const StepView& v) {
  return kEverySet || (v.forces_in_use & bit(F::id)) != 0;
}

/// Calls `run.operator()<forces>()` for the set `forces` in use, which must be a subset of kAmong. A kernel is compiled
/// for each subset, so that it contains no code of unused forces (unless kEverySet is false).
template <unsigned kAmong, unsigned kMask = kAmong, class Run>
void run_for(unsigned forces, Run&& run) {
  if constexpr (!kEverySet) {
    run.template operator()<kAmong>();
  } else if (forces == kMask) {
    run.template operator()<kMask>();
  } else if constexpr (kMask != 0) {
    run_for<kAmong, ((kMask - 1) & kAmong)>(forces, run);
  }
}

}  // namespace simplexseg
