// SPDX-License-Identifier: Apache-2.0
// System of the random walker with a prior, given by its numbers, for experiments on the solver alone.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "field/box_grid.h"

namespace simplexseg {

/// Energy sum g_uv (x_u - x_v)^2 + sum m_v (x_v - t_v)^2 on a grid, where some x_v are fixed (docs/mathematics.md,
/// section 8.5). One value for each cell, i fastest.
struct WalkerSystem {
  BoxGrid grid;
  std::array<double, 3> spacing_mm{1, 1, 1};      ///< of the cells; determines the levels of the multigrid cycle
  std::array<std::vector<float>, 3> conductance;  ///< g between a cell and the next one along i, j, k; 0 at the end
  std::vector<float> prior_weight;                ///< m
  std::vector<std::uint8_t> prior;                ///< t, 0..255 for 0..1
  std::vector<std::uint8_t> fixed;                ///< 1 where x keeps its start, else 0
  std::vector<float> start;                       ///< x at the start
};

struct WalkerSolution {
  std::vector<float> x;
  int iterations = 0;      ///< of the conjugate gradients
  double first_error = 0;  ///< largest correction of the start by one cycle
  double error = 0;        ///< largest correction at the end
  std::size_t bytes = 0;   ///< memory of the solver
};

/// Solves a system until the largest correction is at most `tolerance`, by the solver of the fields of a backend.
using SolveWalkerSystem =
    std::function<WalkerSolution(const WalkerSystem& system, double tolerance, int most_iterations)>;
WalkerSolution solve_walker_on_cpu(const WalkerSystem& system, double tolerance, int most_iterations);

}  // namespace simplexseg
