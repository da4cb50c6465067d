// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "field/field_solver.h"
#include "field/walker_system.h"
#include "step/engine.h"

namespace simplexseg {

enum class Backend { Auto, Cpu, Cuda };

/// Method by which a device samples a volume. Filtered: interpolated by the texture unit (fastest, 8-bit weights).
/// Fetched: texels interpolated in float. Linear: read from linear memory. A volume is always read from linear memory
/// if the texture unit cannot interpolate its voxel type or it exceeds the size of a 3D texture
/// (docs/adr/0008-textures.md).
enum class VolumeSampling { Filtered, Fetched, Linear };

struct EngineChoice {
  std::unique_ptr<Engine> engine;
  std::function<std::unique_ptr<Engine>()>
      make_fallback;  ///< makes the CPU engine for failover; empty unless `backend` is Auto and `engine` uses CUDA
  std::string note;   ///< reason why backend Auto uses the CPU; else empty
  MakeFieldSolver fields = make_cpu_field_solver;  ///< makes field solvers on the device that runs the engine
};
/// Makes the engine of a backend. Auto uses CUDA if a device is usable, otherwise the CPU with the reason in `note`;
/// Cuda throws Error if no device is usable.
EngineChoice make_engine(Backend backend, VolumeSampling sampling = VolumeSampling::Filtered);

/// Code of the CPU kernels. Fastest: eight vertices at once if the CPU supports AVX2, BMI2 and FMA. Plain: one vertex
/// after the other. Both produce bitwise identical results (docs/adr/0025-eight-vertices-at-once.md).
enum class CpuCode { Fastest, Plain };
/// Makes a CPU engine with this number of threads; 0: as many as the hardware runs at the same time.
std::unique_ptr<Engine> make_cpu_engine(int threads = 0, CpuCode code = CpuCode::Fastest);
/// Makes a CUDA engine. Throws Error if built without CUDA or if no device is usable.
std::unique_ptr<Engine> make_cuda_engine(VolumeSampling sampling = VolumeSampling::Filtered);
/// Makes a solver of evidence fields on the device, with its own stream. Throws Error if built without CUDA or if no
/// device is usable. The functions of the solver throw DeviceError if the device fails or runs out of memory.
std::unique_ptr<FieldSolver> make_cuda_field_solver(const Volume& volume, const RunJobs& run,
                                                    const EvidenceSettings& settings);
/// Solves a system of the random walker by the solver of make_cuda_field_solver(). Throws Error like it.
WalkerSolution solve_walker_on_cuda(const WalkerSystem& system, double tolerance, int most_iterations);
/// CUDA stream of the current thread for the lifetime of this object: engines that the thread creates, uses and
/// destroys run concurrently with those of other threads. Has no effect without a device. The constructor throws
/// DeviceError.
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
/// Properties of the device that a CUDA engine would use.
struct CudaDevice {
  std::string name;
  std::size_t bytes_free;
};
/// Properties of the current device; empty if no device is usable.
std::optional<CudaDevice> cuda_device();
/// Reason why CUDA cannot be used ("no CUDA device", "built without CUDA"); empty if it can.
std::string cuda_unavailable_reason();

}  // namespace simplexseg
