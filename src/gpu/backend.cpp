// SPDX-License-Identifier: Apache-2.0
#include "gpu/backend.h"

#include "core/error.h"

namespace simplexseg {

#ifndef SIMPLEXSEG_HAS_CUDA
std::string cuda_unavailable_reason() { return "built without CUDA"; }
std::optional<CudaDevice> cuda_device() { return std::nullopt; }
struct DeviceStream::Impl {};
DeviceStream::DeviceStream() = default;
DeviceStream::~DeviceStream() = default;
std::unique_ptr<Engine> make_cuda_engine(VolumeSampling) {
  throw Error("backend cuda", cuda_unavailable_reason(), "use --backend cpu, or build where nvcc is found");
}
std::unique_ptr<FieldSolver> make_cuda_field_solver(const Volume&, const RunJobs&, const EvidenceSettings&) {
  throw Error("evidence field on cuda", cuda_unavailable_reason(), "use --backend cpu, or build where nvcc is found");
}
WalkerSolution solve_walker_on_cuda(const WalkerSystem&, double, int) {
  throw Error("random walker on cuda", cuda_unavailable_reason(), "use --backend cpu, or build where nvcc is found");
}
#endif

EngineChoice make_engine(Backend backend, VolumeSampling sampling) {
  if (backend == Backend::Cpu) return {make_cpu_engine(), {}, "", make_cpu_field_solver};
  if (backend == Backend::Cuda) return {make_cuda_engine(sampling), {}, "", make_cuda_field_solver};
  std::string reason = cuda_unavailable_reason();
  if (reason.empty()) {
    try {
      return {make_cuda_engine(sampling), [] { return make_cpu_engine(); }, "", make_cuda_field_solver};
    } catch (const Error& error) {
      reason = error.what();
    }
  }
  return {make_cpu_engine(), {}, "running on the CPU: " + reason, make_cpu_field_solver};
}

}  // namespace simplexseg
