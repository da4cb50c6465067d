// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "evidence/field_solver.h"
#include "step/engine.h"

namespace simplexseg {

enum class Backend { Auto, Cpu, Cuda };

/// How the device reads a volume: interpolated by the texture unit (the default: fastest, 8-bit weights), fetched as
/// texels and interpolated in float, or read from linear memory. Voxel types that the texture unit cannot interpolate
/// are always read from linear memory (docs/adr/0008-textures.md).
enum class VolumeSampling { Filtered, Fetched, Linear };

struct EngineChoice {
  std::unique_ptr<Engine> engine;
  std::function<std::unique_ptr<Engine>()>
      make_fallback;  ///< makes the engine that takes over when the device fails; empty unless `backend` is Auto
  std::string note;   ///< why the CPU is used instead of CUDA; empty otherwise
  MakeFieldSolver fields = make_cpu_field_solver;  ///< makes field solvers on the device that runs the engine
};
/// Engine of a backend. Auto uses CUDA if a device is usable, otherwise the CPU with the reason in `note`; Cuda throws
/// Error if no device is usable.
EngineChoice make_engine(Backend backend, VolumeSampling sampling = VolumeSampling::Filtered);

/// Fastest: eight vertices at once with AVX2 if the machine has it. Plain: one vertex after the other. Both give the
/// same bits (docs/adr/0025-eight-vertices-at-once.md).
enum class CpuCode { Fastest, Plain };
/// CPU engine; `threads` = 0 uses all threads of the machine.
std::unique_ptr<Engine> make_cpu_engine(int threads = 0, CpuCode code = CpuCode::Fastest);
/// CUDA engine. Throws Error when built without CUDA or when no device is usable.
std::unique_ptr<Engine> make_cuda_engine(VolumeSampling sampling = VolumeSampling::Filtered);
/// Solver of evidence fields on the device, with its own stream. Throws Error when built without CUDA or when no device
/// is usable; its functions throw DeviceError when the device fails or runs out of memory.
std::unique_ptr<FieldSolver> make_cuda_field_solver(const Volume& volume, const RunJobs& run,
                                                    const EvidenceSettings& settings);
/// Gives the current thread its own CUDA stream for the lifetime of this object: engines that the thread creates, uses
/// and destroys run concurrently with those of other threads. Has no effect without a device. Throws DeviceError.
class DeviceStream {
 public:
  DeviceStream();
  ~DeviceStream();
  DeviceStream(const DeviceStream&) = delete;
  DeviceStream& operator=(const DeviceStream&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
/// Device that a CUDA engine would use.
struct CudaDevice {
  std::string name;
  std::size_t bytes_free;
};
/// Current device; empty when none is usable.
std::optional<CudaDevice> cuda_device();
/// Reason why CUDA cannot be used ("no CUDA device", "built without CUDA"); empty when it can.
std::string cuda_unavailable_reason();

}  // namespace simplexseg
