// SPDX-License-Identifier: Apache-2.0
// Solver of evidence fields on a CUDA device (docs/adr/0032-field-on-a-device.md).
#include "field/parallel/field_solver.h"
#include "field/parallel/walker_system.h"
#include "gpu/backend.h"
#include "gpu/cuda_field_executor.h"

namespace simplexseg {

std::unique_ptr<FieldSolver> make_cuda_field_solver(const Volume& volume, const RunJobs& run,
                                                    const EvidenceSettings& settings) {
  const std::string reason = cuda_unavailable_reason();
  if (!reason.empty()) throw Error("evidence field on cuda", reason, "use --backend cpu");
  return std::make_unique<ParallelFieldSolver<CudaFieldExecutor>>(volume, run, settings);
}

WalkerSolution solve_walker_on_cuda(const WalkerSystem& system, double tolerance, int most_iterations) {
  const std::string reason = cuda_unavailable_reason();
  if (!reason.empty()) throw Error("random walker on cuda", reason, "use --backend cpu");
  return solve_walker_system(CudaFieldExecutor(), system, tolerance, most_iterations);
}

}  // namespace simplexseg
