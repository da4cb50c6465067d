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

/// The searches of a refresh: runs the kernels that each force names (find_targets in src/forces/), and attraction's
/// binding beside the first of them.
template <class Executor>
class TargetSearches {
 public:
  /// `averaging`: an array of one element a vertex, to average in. `bind`: attraction patches are to be found too.
  TargetSearches(Launcher<Executor>& launcher, const StepView& view, const StepNeeds& needs, Vec4* averaging, bool bind)
      : launcher_(launcher), view_(view), needs_(needs), averaging_(averaging), bind_(bind) {}

  /// Those of all forces that search, in a volume of this type.
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

  // What a force finds its targets with.

  const StepView& view() const { return view_; }
  /// Floats that the search of a force keeps at hand.
  int scratch_floats(ForceId force) const { return needs_.scratch[static_cast<int>(force)]; }
  int averaging_passes() const { return needs_.averaging_passes; }

  /// Runs a search over all vertices.
  template <class Kernel>
  void search(const Kernel& kernel) {
    if (bind_)
      launcher_.run_together(kernel, view_.vertex_count, BindPatch{view_}, view_.attraction.count);
    else
      run(kernel);
    bind_ = false;
  }
  /// Runs another kernel over all vertices.
  template <class Kernel>
  void run(const Kernel& kernel) {
    launcher_.run_over_vertices(kernel, view_.vertex_count);
  }
  /// Averages over neighbours, `passes` times, back and forth between an array and another; returns where the result
  /// is.
  const Vec4* average(Vec4* values, int passes, bool targets) {
    Vec4 *from = values, *to = averaging_;
    for (int pass = 0; pass < passes; ++pass) {
      run(AverageOverNeighbours{view_, from, to, pass, targets});
      std::swap(from, to);
    }
    return from;
  }

 private:
  /// The binding, where no search took it along.
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
