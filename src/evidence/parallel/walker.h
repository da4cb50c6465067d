// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "evidence/parallel/executor.h"
#include "evidence/parallel/walker_cycle.h"
#include "evidence/walker_kernels.h"

namespace simplexseg {

/// RandomWalker on an executor: the same system, the same levels, the same cycle in fewer passes. Pointers are to the
/// executor's memory. After a solution it can be carried on from where it stopped.
template <class Executor>
class ParallelWalker {
 public:
  ParallelWalker(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, const Executor& executor)
      : executor_(executor), scalars_(executor.template array<WalkerScalars>(1)) {
    for (const WalkerLevelShape& shape : walker_levels(grid, spacing_mm))
      levels_.emplace_back().grid = shape.grid, levels_.back().halved = shape.halved;
    take_memory();
    held_ = executor.template padded<std::uint8_t>(grid);
    first_of_team_ = 0;
    while (first_of_team_ + 1 < levels_.size() && levels_[first_of_team_].grid.count() > kTeamVoxels) ++first_of_team_;
  }

  const BoxGrid& grid() const { return levels_.front().grid; }
  /// As those of RandomWalker; what leads out of the box must be 0.
  float* weights(int axis) { return levels_.front().weight[axis]; }
  float* pull() { return levels_.front().mass; }
  /// Where to start, 0 at first, then the solution; held voxels keep their value.
  float* field() { return field_; }
  const float* field() const { return field_; }

  struct Report {
    int iterations = 0;
    double error = 0;  ///< largest correction that the last cycle asked for
  };
  /// RandomWalker::solve().
  Report solve(const std::uint8_t* target, const std::uint8_t* held, double tolerance, int most_iterations) {
    executor_.copy(held, held_.data(), grid().count());
    executor_.copy(static_cast<const float*>(field_), inner_, grid().count());
    Level& top = levels_.front();
    const LevelView v = view(top);
    executor_.each(grid().count(),
                   StartOfSolution{StartResidual{v, field_, top.mass, target, held_.data(), top.residual},
                                   HeldIntoMass{v, held_.data(), top.mass}});
    executor_.each(grid().count(),
                   CutAllHeldEdges{
                       held_.data(), {top.weight[0], top.weight[1], top.weight[2]}, {1, grid().row(), grid().plane()}});
    executor_.clear(scalars_.data(), 1);
    taken_ = 0, cycled_ = -1;
    build_levels();
    return carry_on(tolerance, most_iterations);
  }
  /// More of the solution that was begun, to a smaller tolerance: the same field as if that had been asked for at once.
  Report carry_on(double tolerance, int most_iterations) {
    Level& top = levels_.front();
    const int n = grid().count();
    WalkerScalars* const at = scalars_.data();
    float *const r = top.residual, *const z = top.correction, *const p = direction_;
    Report report;
    for (;; ++report.iterations) {
      if (cycled_ != taken_) cycle();
      executor_.largest_into(n, Size{z}, &at->error);
      executor_.sum_into(n, Product{r, z}, taken_ % 2 == 0 ? &at->even : &at->odd);
      const WalkerScalars now = value_at(executor_, at);
      report.error = now.error;
      const double next = taken_ % 2 == 0 ? now.even : now.odd;
      if (!(report.error > tolerance) || report.iterations == most_iterations || !(next > 0)) break;
      executor_.each(n, DirectionOnDevice{at, taken_, z, p});
      executor_.sum_into(n, Apply{view(top), p, z}, &at->curvature);
      executor_.each(n, AdvanceOnDevice{at, taken_, p, z, inner_, r});
      ++taken_;
    }
    executor_.each(n, LastCorrection{inner_, z, held_.data(), field_});
    return report;
  }
  std::size_t bytes() const { return memory_.bytes() + held_.bytes(); }

 private:
  static constexpr int kSolution = 3, kOfLevel = 7;  // arrays
  struct Level {
    BoxGrid grid;
    std::array<bool, 3> halved{};
    std::array<float*, 3> weight{};
    float *mass = nullptr, *diagonal = nullptr, *correction = nullptr, *residual = nullptr;
  };

  /// One array for all, as a walker lives no longer than an update; values, and zeros around them, as
  /// Executor::padded() has them.
  void take_memory() {
    std::size_t all = kSolution * room(grid());
    for (const Level& level : levels_) all += kOfLevel * room(level.grid);
    memory_ = executor_.template array<float>(all);
    executor_.clear(memory_.data(), all);
    float* next = memory_.data();
    const auto take = [&next](const BoxGrid& grid) {
      float* const at = next + grid.plane();
      next += room(grid);
      return at;
    };
    for (float** array : std::array<float**, kSolution>{&field_, &inner_, &direction_}) *array = take(grid());
    for (Level& level : levels_) {
      for (float*& weight : level.weight) weight = take(level.grid);
      for (float** array : {&level.mass, &level.diagonal, &level.correction, &level.residual})
        *array = take(level.grid);
    }
  }
  static std::size_t room(const BoxGrid& grid) {
    constexpr std::size_t aligned = 32;  // as transactions of a device's memory are
    return (std::size_t(grid.count()) + 2 * std::size_t(grid.plane()) + aligned - 1) / aligned * aligned;
  }

  static LevelView view(const Level& level) {
    return {level.grid.row(), level.grid.plane(), level.weight[0], level.weight[1], level.weight[2], level.diagonal};
  }
  static LevelPointers pointers(const Level& level) {
    return {view(level),
            {level.grid.size[0], level.grid.size[1], level.grid.size[2]},
            {level.halved[0] ? 2 : 1, level.halved[1] ? 2 : 1, level.halved[2] ? 2 : 1},
            level.mass,
            level.diagonal,
            level.correction,
            level.residual};
  }
  /// The levels that one team goes through.
  TeamLevels team_levels() const {
    TeamLevels all{};
    for (std::size_t l = first_of_team_; l < levels_.size(); ++l) all.level[all.count++] = pointers(levels_[l]);
    return all;
  }
  void build_levels() {
    for (std::size_t l = 0; l < levels_.size() && l <= first_of_team_; ++l) {
      const LevelPointers level = pointers(levels_[l]);
      if (l > 0) executor_.each(level.count(), Coarsen{pointers(levels_[l - 1]), level});
      executor_.each(level.count(), InverseDiagonal{level.edges, level.mass, level.diagonal});
    }
    executor_.team(BuildOfTeam{team_levels()});
  }
  void cycle() {
    for (std::size_t l = 0; l < first_of_team_; ++l) {
      const LevelPointers fine = pointers(levels_[l]), coarse = pointers(levels_[l + 1]);
      executor_.each(fine.half_count(), FirstSweep{fine});
      executor_.each(coarse.count(), RestrictResidual{fine, coarse});
    }
    executor_.team(CycleOfTeam{team_levels()});
    for (std::size_t l = first_of_team_; l-- > 0;) {
      const LevelPointers fine = pointers(levels_[l]), coarse = pointers(levels_[l + 1]);
      executor_.each(fine.half_count(), SweepWithParents{fine, coarse});
      executor_.each(fine.half_count(), LastSweep{fine});
    }
    cycled_ = taken_;
  }

  /// Voxels of the largest level that a team goes through with all coarser ones in one launch.
  static constexpr int kTeamVoxels = 4096;

  const Executor& executor_;
  std::vector<Level> levels_;
  std::size_t first_of_team_;
  typename Executor::template Array<float> memory_;
  float *field_ = nullptr, *inner_ = nullptr, *direction_ = nullptr;
  typename Executor::template Array<std::uint8_t> held_;
  typename Executor::template Array<WalkerScalars> scalars_;
  int taken_ = 0, cycled_ = -1;  ///< steps of the conjugate gradients, and for how many of them the correction is known
};

/// The counterpart of set_edges() in evidence/conductances.h.
template <class Executor>
void set_edges(const Executor& executor, ParallelWalker<Executor>& walker, const std::array<double, 3>& spacing_mm,
               const float* image, const std::uint8_t* finite, double beta, double pull) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  const BoxGrid& grid = walker.grid();
  AllConductances all{{}, {}, {grid.size[0], grid.size[1], grid.size[2]}};
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = static_cast<float>((least / spacing_mm[axis]) * (least / spacing_mm[axis]));
    all.along[axis] = {image, finite, scale, static_cast<float>(-beta), grid.stride(axis)};
    all.weight[axis] = walker.weights(axis);
  }
  executor.each(grid.count(), all);
  const LevelView edges{grid.row(), grid.plane(), walker.weights(0), walker.weights(1), walker.weights(2), nullptr};
  executor.each(grid.count(), PullOfEdges{edges, static_cast<float>(pull / 6), walker.pull()});
}

}  // namespace simplexseg
