// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "app/console.h"
#include "gpu/backend.h"
#include "io/scene/load_input.h"

namespace simplexseg {

/// Reads a scene with load_scene() and shows progress on a terminal.
LoadedInput load_with_progress(const std::string& path, const LoadOptions& options, const Console& console);
/// Creates the engine of a backend: "auto", "cpu" or "cuda". `threads`: number of CPU threads, 0 for all cores;
/// `sampling`: sampling of the volume by CUDA. Throws Failure if the backend is not available.
EngineChoice engine_for(const std::string& backend, int threads, VolumeSampling sampling = VolumeSampling::Filtered);
/// Prints the warnings of a reader, one line each. Call it after all checks of the input, because invalid input must
/// print only the line with the error.
void print_warnings(const std::vector<std::string>& warnings, const Console& console);

}  // namespace simplexseg
