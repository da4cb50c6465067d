// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <limits>
#include <span>

#include "field/parallel/walker.h"
#include "field/walker_system.h"

namespace simplexseg {

/// Solves a system on an executor (SolveWalkerSystem).
template <class Executor>
WalkerSolution solve_walker_system(const Executor& executor, const WalkerSystem& system, double tolerance,
                                   int most_iterations) {
  ParallelWalker<Executor> walker(system.grid, system.spacing_mm, executor);
  for (int axis = 0; axis < 3; ++axis)
    executor.upload(std::span<const float>(system.conductance[axis]), walker.conductances(axis));
  executor.upload(std::span<const float>(system.prior_weight), walker.prior_weight());
  executor.upload(std::span<const float>(system.start), walker.field());
  const auto prior = executor.copy_of(std::span<const std::uint8_t>(system.prior)),
             fixed = executor.copy_of(std::span<const std::uint8_t>(system.fixed));
  WalkerSolution solution;
  // Any first correction is within an infinite tolerance; resuming gives the bits of one call.
  walker.solve(prior.data(), fixed.data(), std::numeric_limits<double>::infinity(), most_iterations);
  solution.first_error = walker.report().error;
  walker.resume(tolerance, most_iterations);
  const auto report = walker.report();
  solution.iterations = report.iterations, solution.error = report.error;
  solution.bytes = walker.bytes();
  solution.x.resize(system.start.size());
  executor.download(static_cast<const ParallelWalker<Executor>&>(walker).field(), std::span<float>(solution.x));
  return solution;
}

}  // namespace simplexseg
