// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/expect.h"
#include "field/parallel/executor.h"
#include "field/parallel/walker_cycle.h"
#include "field/walker_kernels.h"

namespace simplexseg {

/// P(object) on a box by the random walker with a prior (Grady 2005, Multilabel random walker image segmentation using
/// prior models): minimises sum w_ab (x_a - x_b)^2 + sum pull_v (x_v - target_v)^2, x being fixed in the marks. Solved
/// by conjugate gradients with a multigrid cycle of piecewise constant interpolation as the preconditioner
/// (walker_cycle.h). Pointers are to the executor's memory. A solution can be resumed.
template <class Executor>
class ParallelWalker {
 public:
  ParallelWalker(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, const Executor& executor)
      : executor_(executor), state_(executor.template array<WalkerState>(1)) {
    for (const WalkerLevelShape& shape : walker_levels(grid, spacing_mm))
      levels_.emplace_back().grid = shape.grid, levels_.back().halved = shape.halved;
    take_memory();
    held_ = executor.template padded<std::uint8_t>(grid);
    SIMPLEXSEG_EXPECT(levels_.size() <= kMaxLevels);
    for (std::size_t l = 0; l < levels_.size(); ++l) all_.level[l] = pointers(levels_[l]);
    all_.count = static_cast<int>(levels_.size());
    while (all_.first_of_some + 1 < all_.count && levels_[all_.first_of_some].grid.count() > kVoxelsOfSome)
      ++all_.first_of_some;
  }

  const BoxGrid& grid() const { return levels_.front().grid; }
  /// Conductances between a cell and the next one along an axis; those that lead out of the box must be 0.
  float* weights(int axis) { return levels_.front().weight[axis]; }
  float* pull() { return levels_.front().mass; }
  /// Where to start, 0 at first, then the solution; held voxels keep their value.
  float* field() { return field_; }
  const float* field() const { return field_; }

  struct Report {
    int iterations = 0;
    double error = 0;  ///< largest correction that the last cycle asked for
  };
  /// Solves for x until the largest correction is at most `tolerance`. `target`: 0..255 for 0..1; `held`: 1 where x
  /// is fixed. Does not wait.
  void solve(const std::uint8_t* target, const std::uint8_t* held, double tolerance, int most_iterations,
             const ReportProgress& progress = {}) {
    executor_.copy(held, held_.data(), grid().count());
    run(target, tolerance, most_iterations, false, progress);
  }
  /// More of the solution that was begun, to a smaller tolerance: the same field as if that had been asked for at once.
  void resume(double tolerance, int most_iterations, const ReportProgress& progress = {}) {
    run(nullptr, tolerance, most_iterations, true, progress);
  }
  /// Of the last call: what is fetched, and waited for, at once or later.
  typename Executor::template Fetched<WalkerState> fetch_report() const { return executor_.fetch(state_.data(), 1); }
  Report report(const typename Executor::template Fetched<WalkerState>& fetched) const {
    const auto state = received<WalkerState>(executor_, fetched);
    return {state.iterations, state.error};
  }
  Report report() const { return report(fetch_report()); }
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
    return {view(level),   level.grid,     {level.halved[0] ? 1 : 0, level.halved[1] ? 1 : 0, level.halved[2] ? 1 : 0},
            level.mass,    level.diagonal, level.correction,
            level.residual};
  }
  void run(const std::uint8_t* target, double tolerance, int most_iterations, bool resumes,
           const ReportProgress& progress) {
    executor_.all(SolveWalker{all_, target, held_.data(), field_, inner_, direction_, tolerance, most_iterations,
                              resumes, state_.data()},
                  progress);
  }

  /// Voxels of the largest level that a part of the threads goes through, with all coarser ones.
  static constexpr int kVoxelsOfSome = 4096;

  const Executor& executor_;
  std::vector<Level> levels_;
  WalkerLevels all_{};
  typename Executor::template Array<float> memory_;
  float *field_ = nullptr, *inner_ = nullptr, *direction_ = nullptr;
  typename Executor::template Array<std::uint8_t> held_;
  typename Executor::template Array<WalkerState> state_;
};

/// Sets the conductances exp(-beta d^2) (least spacing / spacing)^2 for a difference d of neighbours, 0 beside cells
/// that are not finite, and a pull of so many mean conductances of a cell.
template <class Executor>
void set_edges(const Executor& executor, ParallelWalker<Executor>& walker, const std::array<double, 3>& spacing_mm,
               const float* image, const std::uint8_t* finite, double beta, double pull) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  const BoxGrid& grid = walker.grid();
  AllConductances all{{}, {}, grid};
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = static_cast<float>((least / spacing_mm[axis]) * (least / spacing_mm[axis]));
    all.along[axis] = {image, finite, scale, static_cast<float>(-beta), grid.stride(axis)};
    all.weight[axis] = walker.weights(axis);
  }
  executor.each_cell(grid, all);
  const LevelView edges{grid.row(), grid.plane(), walker.weights(0), walker.weights(1), walker.weights(2), nullptr};
  executor.each(grid.count(), PullOfEdges{edges, static_cast<float>(pull / 6), walker.pull()});
}

}  // namespace simplexseg
