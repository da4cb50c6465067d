// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

#include "core/engine.h"

namespace simplexseg {

enum class Backend { Auto, Cpu, Cuda };

struct EngineChoice {
  std::unique_ptr<Engine> engine;
  std::string note;          ///< why the CPU was taken where CUDA was wanted; empty when there is nothing to say
};
/// Auto takes CUDA where a usable device is, else the CPU with the reason; Cuda throws Error where there is none.
EngineChoice make_engine(Backend backend);

/// `threads` = 0: as many as the machine has.
std::unique_ptr<Engine> make_cpu_engine(int threads = 0);
/// Throws Error when built without CUDA or no device answers.
std::unique_ptr<Engine> make_cuda_engine();
/// Empty when a CUDA device can be used; otherwise the reason in a few words ("no CUDA device", "built without CUDA").
std::string why_no_cuda();

}  // namespace simplexseg
