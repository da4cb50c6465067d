// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "cli/commands.h"
#include "gpu/backend.h"
#include "io/load_input.h"

namespace simplexseg {

/// load_scene() with the --set options, and with progress on a terminal.
LoadedInput load_with_progress(const std::string& path, const std::vector<std::string>& settings,
                               const Console& console, LoadOptions::History history = LoadOptions::History::LeaveOut);
/// `backend`: "auto", "cpu" or "cuda"; `threads` of the CPU, 0: as many as there are. Throws Failure where it cannot be
/// had.
EngineChoice engine_for(const std::string& backend, int threads, VolumeSampling sampling = VolumeSampling::Filtered);
/// Prints what was noticed while a scene was read. To be called later than any refusal: bad input is answered in one
/// line.
void print_warnings(const std::vector<std::string>& warnings, const Console& console);

}  // namespace simplexseg
