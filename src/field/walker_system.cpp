// SPDX-License-Identifier: Apache-2.0
#include "field/walker_system.h"

#include "field/parallel/cpu_executor.h"
#include "field/parallel/walker_system.h"

namespace simplexseg {

WalkerSolution solve_walker_on_cpu(const WalkerSystem& system, double tolerance, int most_iterations) {
  return solve_walker_system(CpuFieldExecutor(), system, tolerance, most_iterations);
}

}  // namespace simplexseg
