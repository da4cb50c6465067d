// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "field/walker_system.h"

namespace simplexseg {

/// Exact solution of a system of the random walker by elimination of its free cells without subtractions, in double.
/// Each x has a small relative error whatever the range of the conductances. Cells that are connected to no fixed cell
/// and have no prior keep their start. Costs (number of free cells)^3 / 3 operations. Source: Grassmann, Taksar and
/// Heyman 1985, Regenerative analysis and steady state distributions for Markov chains.
std::vector<double> exact_walker_solution(const WalkerSystem& system);

}  // namespace simplexseg
