// SPDX-License-Identifier: Apache-2.0
// The system of the random walker with priors, and its solver.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evidence/padded_array.h"
#include "evidence/run_jobs.h"
#include "evidence/update_progress.h"

namespace simplexseg {

/// Minimises sum over neighbours w_vu (x_v - x_u)^2 + sum over voxels m_v (x_v - t_v)^2, marked voxels held (Grady
/// 2006, Random Walks for Image Segmentation; Grady 2005, Multilabel Random Walker Image Segmentation Using Prior
/// Models). x lies between the least and the largest of t and the held values.
///
/// Conjugate gradients, preconditioned by one multigrid cycle: levels of boxes of two voxels along each axis that
/// couples strongly, constant in a box (the conductances between two boxes add up), a red-black sweep before and
/// after. The same bits at any number of threads.
class RandomWalker {
 public:
  /// `spacing_mm`: distances of neighbours along i, j, k. It says along which axes neighbours couple strongly; that
  /// conductances fall with its square is for the caller to see to.
  RandomWalker(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, RunJobs run);

  const BoxGrid& grid() const { return levels_.front().grid; }
  /// Conductance between voxel v and the next one along an axis, >= 0. Those beyond the box are ignored.
  std::span<float> weights(int axis) { return {levels_.front().weight[axis].data(), std::size_t(grid().count())}; }
  /// Pull m >= 0 towards the target.
  std::span<float> pull() { return {levels_.front().mass.data(), std::size_t(grid().count())}; }
  /// The field: where to start, then the solution. Held voxels keep their value.
  std::span<float> field() { return {field_.data(), std::size_t(grid().count())}; }
  std::span<const float> field() const { return {field_.data(), std::size_t(grid().count())}; }

  struct Report {
    int iterations = 0;
    double error = 0;  ///< largest correction that the last cycle asked for
  };
  /// `target`: t, 0..255 for 0..1; `held`: not 0 where the field is given. Overwrites weights and pull. Stops when no
  /// voxel asks for a correction above `tolerance`, or after `most_iterations`. `progress`, unless empty, receives the
  /// completed part before each iteration: log(first / present error) / log(first error / tolerance); it may decrease.
  Report solve(std::span<const std::uint8_t> target, std::span<const std::uint8_t> held, double tolerance,
               int most_iterations, const ReportProgress& progress = {});
  /// More of the solution that was begun, to a smaller tolerance: the same field as if that had been asked for at once.
  Report resume(double tolerance, int most_iterations, const ReportProgress& progress = {});
  std::size_t bytes() const;

 private:
  struct Level {
    BoxGrid grid;
    std::array<bool, 3> halved{};  ///< axes along which the next level has half the voxels
    std::array<PaddedArray<float>, 3> weight;
    PaddedArray<float> mass, diagonal;
    PaddedArray<float> correction, residual;
  };

  void eliminate_held(std::span<const std::uint8_t> target, std::span<const std::uint8_t> held);
  void build_levels();
  void coarsen(const Level& fine, Level& coarse) const;
  void set_diagonal(Level& level) const;
  void cycle(std::size_t level);
  void restrict_residual(const Level& fine, Level& coarse) const;
  void sweep(Level& level, int colour, bool from_zero) const;
  double largest_correction() const;

  RunJobs run_;
  std::vector<Level> levels_;
  PaddedArray<float> field_, inner_, direction_;  ///< inner: the solution without the last correction
  double product_ = 0;                            ///< of residual and correction, at the last direction; 0 before one
  bool cycled_ = false;                           ///< is the correction that of the residual?
};

}  // namespace simplexseg
