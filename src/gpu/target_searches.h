// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <type_traits>
#include <utility>

#include "forces/force_list.h"
#include "gpu/forces_in_use.h"
#include "gpu/launcher.h"
#include "image/volume.h"
#include "step/step_needs.h"

namespace simplexseg {

/// Searches of a refresh. Runs the kernels of each force (find_targets in src/forces/) and, concurrently with the first
/// of them, the binding of attraction points.
template <class Executor>
class TargetSearches {
 public:
  /// `averaging`: workspace of one element per vertex; `bind`: whether to compute the attraction patches, too.
  TargetSearches(Launcher<Executor>& launcher, const StepView& view, const StepNeeds& needs, Vec4* averaging, bool bind)
      : launcher_(launcher), view_(view), needs_(needs), averaging_(averaging), bind_(bind) {}

  /// Runs the searches of all forces in a volume of this voxel type.
  void search_all(VoxelType type) {
    Executor& executor = launcher_.executor;
    if (needs_.searches())
      executor.visit_voxels(type, [&]<class Voxels>(std::type_identity<Voxels>) {
        executor.visit_width(view_.vertex_count, [&]<int kWidth>(std::integral_constant<int, kWidth>) {
          each_force([&]<class F>(F) {
            if constexpr (HasTargets<F> && (kBuiltForces & bit(F::id)) != 0)
              if (needs_.searches(F::id)) F::template find_targets<Voxels, kWidth>(*this);
          });
        });
      });
    finish();
  }

  // Interface for the functions find_targets() of the forces.

  const StepView& view() const { return view_; }
  /// Scratch memory that the search of a force needs for one vertex, floats.
  int scratch_floats(ForceId force) const { return needs_.scratch[static_cast<int>(force)]; }
  int averaging_passes() const { return needs_.averaging_passes; }

  /// Runs a search over all vertices.
  template <class Kernel>
  void search(const Kernel& kernel) {
    if (bind_)
      launcher_.run_concurrently(kernel, view_.vertex_count, BindPatch{view_}, view_.attraction.count);
    else
      run(kernel);
    bind_ = false;
  }
  /// Runs a kernel other than a search over all vertices.
  template <class Kernel>
  void run(const Kernel& kernel) {
    launcher_.run_over_vertices(kernel, view_.vertex_count);
  }
  /// Averages over neighbours, `passes` times, alternating between `values` and the workspace; returns the array with
  /// the result. `targets`: as in AverageOverNeighbours.
  const Vec4* average(Vec4* values, int passes, bool targets) {
    Vec4 *from = values, *to = averaging_;
    for (int pass = 0; pass < passes; ++pass) {
      run(AverageOverNeighbours{view_, from, to, pass, targets});
      std::swap(from, to);
    }
    return from;
  }

 private:
  /// Computes the attraction patches, if requested, unless search() has computed them.
  void finish() {
    if (bind_) launcher_.run(BindPatch{view_}, view_.attraction.count);
    bind_ = false;
  }

  Launcher<Executor>& launcher_;
  const StepView& view_;
  const StepNeeds& needs_;
  Vec4* averaging_;
  bool bind_;
};

}  // namespace simplexseg
