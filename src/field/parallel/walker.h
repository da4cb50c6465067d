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

/// Random walker with a prior on a box: minimises sum g_uv (x_u - x_v)^2 + sum m_v (x_v - target_v)^2, where x is fixed
/// in constrained cells, by conjugate gradients with a multigrid V-cycle as the preconditioner (walker_cycle.h).
/// Pointers are to the memory of the executor. Source: Grady 2005, Multilabel random walker image segmentation using
/// prior models.
template <class Executor>
class ParallelWalker {
 public:
  ParallelWalker(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, const Executor& executor)
      : executor_(executor), state_(executor.template array<WalkerState>(1)) {
    for (const WalkerLevelShape& shape : walker_levels(grid, spacing_mm))
      levels_.emplace_back().grid = shape.grid, levels_.back().halved = shape.halved;
    allocate_workspace();
    fixed_ = executor.template padded<std::uint8_t>(grid);
    SIMPLEXSEG_EXPECT(levels_.size() <= kMaxLevels);
    for (std::size_t l = 0; l < levels_.size(); ++l) all_.level[l] = pointers(levels_[l]);
    all_.count = static_cast<int>(levels_.size());
    while (all_.first_small_level + 1 < all_.count && levels_[all_.first_small_level].grid.count() > kCellsOfOneBlock)
      ++all_.first_small_level;
  }

  const BoxGrid& grid() const { return levels_.front().grid; }
  /// Conductances g between a cell and the next one along an axis; 0 for the last cells.
  float* conductances(int axis) { return levels_.front().conductance[axis]; }
  /// Weights m of the prior. They and the conductances are overwritten by solve().
  float* prior_weight() { return levels_.front().excess; }
  /// Start, 0 after construction, then the solution x; values of fixed cells are not changed.
  float* field() { return field_; }
  const float* field() const { return field_; }

  struct Report {
    int iterations = 0;
    double error = 0;  ///< largest correction of the last cycle
  };
  /// Solves for x until the largest correction is at most `tolerance`. `target`: 0..255 for 0..1; `fixed`: 1 where x is
  /// fixed, else 0. Does not wait.
  void solve(const std::uint8_t* target, const std::uint8_t* fixed, double tolerance, int most_iterations,
             const ReportProgress& progress = {}) {
    executor_.copy(fixed, fixed_.data(), grid().count());
    run(target, tolerance, most_iterations, false, progress);
  }
  /// Continues the last solution to a smaller tolerance; the result has the bits of a single call with that tolerance.
  void resume(double tolerance, int most_iterations, const ReportProgress& progress = {}) {
    run(nullptr, tolerance, most_iterations, true, progress);
  }
  /// Report of the last call: begins its download, or waits for it.
  typename Executor::template Fetched<WalkerState> fetch_report() const { return executor_.fetch(state_.data(), 1); }
  Report report(const typename Executor::template Fetched<WalkerState>& fetched) const {
    const auto state = received<WalkerState>(executor_, fetched);
    return {state.iterations, state.error};
  }
  Report report() const { return report(fetch_report()); }
  std::size_t bytes() const { return memory_.bytes() + fixed_.bytes(); }

 private:
  static constexpr int kSolution = 3, kOfLevel = 7;  // arrays
  struct Level {
    BoxGrid grid;
    std::array<bool, 3> halved{};
    std::array<float*, 3> conductance{};
    float *excess = nullptr, *inverse_diagonal = nullptr, *correction = nullptr, *residual = nullptr;
  };

  /// Allocates one array for all levels; each list is padded by zeros like Executor::padded().
  void allocate_workspace() {
    std::size_t all = kSolution * padded_count(grid());
    for (const Level& level : levels_) all += kOfLevel * padded_count(level.grid);
    memory_ = executor_.template array<float>(all);
    executor_.clear(memory_.data(), all);
    float* next = memory_.data();
    const auto allocate = [&next](const BoxGrid& grid) {
      float* const at = next + grid.plane();
      next += padded_count(grid);
      return at;
    };
    for (float** array : std::array<float**, kSolution>{&field_, &iterate_, &direction_}) *array = allocate(grid());
    for (Level& level : levels_) {
      for (float*& conductance : level.conductance) conductance = allocate(level.grid);
      for (float** array : {&level.excess, &level.inverse_diagonal, &level.correction, &level.residual})
        *array = allocate(level.grid);
    }
  }
  static std::size_t padded_count(const BoxGrid& grid) {
    constexpr std::size_t aligned = 32;  // floats of a memory transaction of a device
    return (std::size_t(grid.count()) + 2 * std::size_t(grid.plane()) + aligned - 1) / aligned * aligned;
  }

  static LevelView view(const Level& level) {
    return {level.grid.row(),     level.grid.plane(),   level.conductance[0],
            level.conductance[1], level.conductance[2], level.inverse_diagonal};
  }
  static LevelPointers pointers(const Level& level) {
    return {view(level),
            level.grid,
            {level.halved[0] ? 1 : 0, level.halved[1] ? 1 : 0, level.halved[2] ? 1 : 0},
            level.excess,
            level.inverse_diagonal,
            level.correction,
            level.residual};
  }
  void run(const std::uint8_t* target, double tolerance, int most_iterations, bool resumes,
           const ReportProgress& progress) {
    executor_.all(SolveWalker{all_, target, fixed_.data(), field_, iterate_, direction_, tolerance, most_iterations,
                              resumes, state_.data()},
                  progress);
  }

  /// Cells of the largest level that is processed by one block, with all coarser levels.
  static constexpr int kCellsOfOneBlock = 4096;

  const Executor& executor_;
  std::vector<Level> levels_;
  WalkerLevels all_{};
  typename Executor::template Array<float> memory_;
  float *field_ = nullptr, *iterate_ = nullptr, *direction_ = nullptr;
  typename Executor::template Array<std::uint8_t> fixed_;
  typename Executor::template Array<WalkerState> state_;
};

/// Sets the conductances exp(-beta d^2) (smallest spacing / spacing)^2 for an intensity difference d of neighbours, 0
/// beside cells that are not finite. `prior_weight`: weight of the prior, mean conductances of a cell.
template <class Executor>
void set_edges(const Executor& executor, ParallelWalker<Executor>& walker, const std::array<double, 3>& spacing_mm,
               const float* image, const std::uint8_t* finite, double beta, double prior_weight) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  const BoxGrid& grid = walker.grid();
  AllConductances all{{}, {}, grid};
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = static_cast<float>((least / spacing_mm[axis]) * (least / spacing_mm[axis]));
    all.along[axis] = {image, finite, scale, static_cast<float>(-beta), grid.stride(axis)};
    all.conductance[axis] = walker.conductances(axis);
  }
  executor.each_cell(grid, all);
  const LevelView edges{
      grid.row(), grid.plane(), walker.conductances(0), walker.conductances(1), walker.conductances(2), nullptr};
  executor.each(grid.count(), PriorWeights{edges, static_cast<float>(prior_weight / 6), walker.prior_weight()});
}

}  // namespace simplexseg
