// SPDX-License-Identifier: Apache-2.0
// All forces, and what is said of each of them by its header. Whoever has to do with every force visits them here and
// names none, so that a new one is its header and its line in src/forces/CMakeLists.txt (docs/add-a-force.md).
#pragma once
#include <tuple>

#include "forces/force_types.h"

namespace simplexseg {

static_assert(std::tuple_size_v<Forces> == kForceCount);

namespace detail {
#ifdef __CUDACC__
#pragma nv_exec_check_disable  // what is visited on the host need not run on a device
#endif
template <class Visit, class... F>
SIMPLEXSEG_HD constexpr void each_of(std::tuple<F...>*, Visit& visit) {
  (visit(F{}), ...);
}
}  // namespace detail

/// visit(F{}) for each force F, in the order of ForceId.
#ifdef __CUDACC__
#pragma nv_exec_check_disable
#endif
template <class Visit>
SIMPLEXSEG_HD constexpr void each_force(Visit&& visit) {
  detail::each_of(static_cast<Forces*>(nullptr), visit);
}

/// The bit of a force in a set of forces.
constexpr unsigned bit(ForceId force) { return 1u << static_cast<int>(force); }

/// The force says where each vertex is drawn to; all but those that pull do.
template <class F>
concept Displaces = requires(const StepView& v, const MeshConstants& m, int i, Int4 neighbours, Vec3 p, Vec4 frame) {
  F::displacement(v, m, i, neighbours, p, frame);
};
/// The force is summed over what the user placed, before the step; image forces fade where it pulls.
template <class F>
concept Pulls = requires(const StepView& v, const MeshConstants& m, int i, Vec3& force, float& x) {
  F::take_pull(v, m, i, force, x, x);
};
/// The force finds a target for each vertex at each refresh, which is kept in between.
template <class F>
concept HasTargets = requires {
  F::targets_name;
};

/// The forces F of which `holds(F{})` is true, as a set of bits.
template <class Holds>
constexpr unsigned forces_where(Holds&& holds) {
  unsigned forces = 0;
  each_force([&]<class F>(F force) {
    if (holds(force)) forces |= bit(F::id);
  });
  return forces;
}
inline constexpr unsigned kInternalForces = forces_where([]<class F>(F) { return F::kind == ForceKind::Internal; });
inline constexpr unsigned kImageForces = forces_where([]<class F>(F) { return F::kind == ForceKind::Image; });
inline constexpr unsigned kPullingForces = forces_where([]<class F>(F) { return Pulls<F>; });
inline constexpr unsigned kForcesWithTargets = forces_where([]<class F>(F) { return HasTargets<F>; });

/// The share of its stability bound that a force has at a vertex: 1 unless the force says how far it trusts its target.
template <class F, class I>
SIMPLEXSEG_HD Real<I> trust_of(const StepView& v, I i) {
  if constexpr (requires { F::trust(v, i); }) {
    return F::trust(v, i);
  } else if constexpr (requires { F::trust(v, 0); }) {
    auto all = one_by_one(Real<I>(1.0f));
    each(i, [&](int one, int lane) { all[lane] = F::trust(v, one); });
    return all.together();
  } else {
    return 1.0f;
  }
}
/// F::displacement, one vertex after another where the force is not written for several.
template <class F, class I, class Neighbours, class R>
SIMPLEXSEG_HD Vec3Of<R> displacement_of(const StepView& v, const MeshConstants& m, I i, Neighbours nb, Vec3Of<R> p,
                                        Vec4Of<R> frame) {
  if constexpr (requires { F::displacement(v, m, i, nb, p, frame); }) {
    return F::displacement(v, m, i, nb, p, frame);
  } else {
    auto all = one_by_one(p);
    each(i, [&](int one, int lane) {
      all.set(lane, F::displacement(v, m, one, v.neighbours[one], xyz(v.current[one]), v.frame[one]));
    });
    return all.together();
  }
}
/// F::take_pull of each vertex.
template <class F, class I, class R>
SIMPLEXSEG_HD void pull_of(const StepView& v, const MeshConstants& m, I i, Vec3Of<R>& force, R& stiffness, R& image) {
  if constexpr (std::is_same_v<R, float>) {
    F::take_pull(v, m, i, force, stiffness, image);
  } else {
    auto forces = one_by_one(force);
    auto bounds = one_by_one(stiffness), left = one_by_one(image);
    each(i, [&](int one, int lane) {
      Vec3 own = forces[lane];
      F::take_pull(v, m, one, own, bounds[lane], left[lane]);
      forces.set(lane, own);
    });
    force = forces.together(), stiffness = bounds.together(), image = left.together();
  }
}

}  // namespace simplexseg
