// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "evidence/box_field.h"
#include "step/engine.h"

namespace simplexseg {

enum class Backend { Auto, Cpu, Cuda };

/// How a device reads a volume that its texture unit can filter: filtered by the texture unit (the default: fastest,
/// with fractions of 8 bits), fetched and interpolated in float, or from linear memory. Figures:
/// docs/adr/0008-textures.md.
enum class VolumeSampling { Filtered, Fetched, Linear };

struct EngineChoice {
  std::unique_ptr<Engine> engine;
  std::function<std::unique_ptr<Engine>()>
      spare;         ///< takes over when the device fails; none where a backend was asked for
  std::string note;  ///< why the CPU was taken where CUDA was wanted; empty when there is nothing to say
  MakeBoxField fields = make_cpu_box_field;  ///< evidence fields are learned where the engine runs
};
/// Auto takes CUDA where a usable device is, else the CPU with the reason; Cuda throws Error where there is none.
EngineChoice make_engine(Backend backend, VolumeSampling sampling = VolumeSampling::Filtered);

/// Eight vertices at once where the machine can, or one after the other: the bits are the same
/// (docs/adr/0025-eight-vertices-at-once.md).
enum class CpuCode { Fastest, Plain };
/// `threads` = 0: as many as the machine has.
std::unique_ptr<Engine> make_cpu_engine(int threads = 0, CpuCode code = CpuCode::Fastest);
/// Throws Error when built without CUDA or no device answers.
std::unique_ptr<Engine> make_cuda_engine(VolumeSampling sampling = VolumeSampling::Filtered);
/// Evidence fields on the device, each on a stream of its own. Throws Error when built without CUDA or no device
/// answers; all that it does later throws DeviceError when the device fails or has not the memory.
std::unique_ptr<BoxField> make_cuda_box_field(const Volume& volume, const RunJobs& run,
                                              const EvidenceSettings& settings);
/// While one lives, the engines that its thread makes, uses and destroys have a stream of their own on the device: they
/// run beside those of other threads. Without a device it does nothing. Throws DeviceError.
class DeviceStream {
 public:
  DeviceStream();
  ~DeviceStream();
  DeviceStream(const DeviceStream&) = delete;
  DeviceStream& operator=(const DeviceStream&) = delete;

 private:
  struct Own;
  std::unique_ptr<Own> own_;
};
/// The device that an engine would take; none when there is none.
struct CudaDevice {
  std::string name;
  std::size_t bytes_free;
};
std::optional<CudaDevice> cuda_device();
/// Empty when a CUDA device can be used; otherwise the reason in a few words ("no CUDA device", "built without CUDA").
std::string why_no_cuda();

}  // namespace simplexseg
