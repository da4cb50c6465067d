// SPDX-License-Identifier: Apache-2.0
// The evidence field on a CUDA device (docs/adr/0032-the-field-on-a-device.md).
#include "evidence/parallel/box_field.h"
#include "gpu/backend.h"
#include "gpu/cuda_field_executor.h"

namespace simplexseg {

std::unique_ptr<BoxField> make_cuda_box_field(const Volume& volume, const RunJobs& run,
                                              const EvidenceSettings& settings) {
  const std::string reason = why_no_cuda();
  if (!reason.empty()) throw Error("evidence field on cuda", reason, "use --backend cpu");
  return std::make_unique<ParallelBoxField<CudaFieldExecutor>>(volume, run, settings);
}

}  // namespace simplexseg
