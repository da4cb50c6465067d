// SPDX-License-Identifier: Apache-2.0
// List of all forces, and compile-time queries of their properties. Code that handles all forces visits them through
// this header without naming any, so a new force requires only a header and a line in src/forces/CMakeLists.txt
// (docs/add-a-force.md).
#pragma once
#include <tuple>

#include "forces/force_types.h"

namespace simplexseg {

static_assert(std::tuple_size_v<Forces> == kForceCount);

namespace detail {
#ifdef __CUDACC__
#pragma nv_exec_check_disable  // functions visited on the host need not run on a device
#endif
template <class Visit, class... F>
SIMPLEXSEG_HD constexpr void each_of(std::tuple<F...>*, Visit& visit) {
  (visit(F{}), ...);
}
}  // namespace detail

/// Calls visit(F{}) for each force F, in the order of ForceId.
#ifdef __CUDACC__
#pragma nv_exec_check_disable
#endif
template <class Visit>
SIMPLEXSEG_HD constexpr void each_force(Visit&& visit) {
  detail::each_of(static_cast<Forces*>(nullptr), visit);
}

/// Bit mask of a force in a set of forces.
constexpr unsigned bit(ForceId force) { return 1u << static_cast<int>(force); }

/// Force that computes a displacement for each vertex. Every force satisfies either this concept or Pulls.
template <class F>
concept Displaces = requires(const StepView& v, const MeshConstants& m, int i, Int4 neighbours, Vec3 p, Vec4 frame) {
  F::displacement(v, m, i, neighbours, p, frame);
};
/// Force that pulls vertices to points placed by the user. The pulls are summed before the step, and image forces fade
/// where they act.
template <class F>
concept Pulls = requires(const StepView& v, const MeshConstants& m, int i, Vec3& force, float& x) {
  F::apply_pull(v, m, i, force, x, x);
};
/// Force that finds a target for each vertex at each refresh and uses this target until the next refresh.
template <class F>
concept HasTargets = requires {
  F::targets_name;
};

/// Set of the forces F for which `predicate(F{})` is true.
template <class Predicate>
constexpr unsigned forces_where(Predicate&& predicate) {
  unsigned forces = 0;
  each_force([&]<class F>(F force) {
    if (predicate(force)) forces |= bit(F::id);
  });
  return forces;
}
inline constexpr unsigned kInternalForces = forces_where([]<class F>(F) { return F::kind == ForceKind::Internal; });
inline constexpr unsigned kImageForces = forces_where([]<class F>(F) { return F::kind == ForceKind::Image; });
inline constexpr unsigned kPullingForces = forces_where([]<class F>(F) { return Pulls<F>; });
inline constexpr unsigned kForcesWithTargets = forces_where([]<class F>(F) { return HasTargets<F>; });

/// Confidence in the target of a force at vertex i, which is also the stiffness of the force there, at most its
/// stability bound. 1 for a force without targets.
template <class F, class I>
SIMPLEXSEG_HD Real<I> confidence_of(const StepView& v, I i) {
  if constexpr (requires { F::confidence(v, i); }) {
    return F::confidence(v, i);
  } else if constexpr (requires { F::confidence(v, 0); }) {
    auto all = unpack_lanes(Real<I>(1.0f));
    each(i, [&](int one, int lane) { all[lane] = F::confidence(v, one); });
    return all.pack();
  } else {
    return 1.0f;
  }
}
/// F::displacement, mm; evaluated separately for each vertex if the force does not support several at once.
template <class F, class I, class Neighbours, class R>
SIMPLEXSEG_HD Vec3Of<R> displacement_of(const StepView& v, const MeshConstants& m, I i, Neighbours nb, Vec3Of<R> p,
                                        Vec4Of<R> frame) {
  if constexpr (requires { F::displacement(v, m, i, nb, p, frame); }) {
    return F::displacement(v, m, i, nb, p, frame);
  } else {
    auto all = unpack_lanes(p);
    each(i, [&](int one, int lane) {
      all.set(lane, F::displacement(v, m, one, v.neighbours[one], xyz(v.current[one]), v.frame[one]));
    });
    return all.pack();
  }
}
/// Calls F::apply_pull for each vertex of i.
template <class F, class I, class R>
SIMPLEXSEG_HD void pull_of(const StepView& v, const MeshConstants& m, I i, Vec3Of<R>& force, R& stiffness, R& image) {
  if constexpr (std::is_same_v<R, float>) {
    F::apply_pull(v, m, i, force, stiffness, image);
  } else {
    auto forces = unpack_lanes(force);
    auto bounds = unpack_lanes(stiffness), factors = unpack_lanes(image);
    each(i, [&](int one, int lane) {
      Vec3 one_force = forces[lane];
      F::apply_pull(v, m, one, one_force, bounds[lane], factors[lane]);
      forces.set(lane, one_force);
    });
    force = forces.pack(), stiffness = bounds.pack(), image = factors.pack();
  }
}

}  // namespace simplexseg
