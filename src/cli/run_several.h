// SPDX-License-Identifier: Apache-2.0
// Many scenes in one process: they share a device and its context, and what starting a program takes is paid for once.
#pragma once
#include <string>
#include <vector>

#include "cli/run_scene.h"

namespace simplexseg {

/// What stands for a scene's name in the names of outputs.
inline constexpr const char* kNameOfScene = "{name}";

/// `options` with a scene's name, which is that of its file without the ending, in the names of outputs.
RunOptions options_for(const std::string& scene, const RunOptions& options);

/// Reads and runs one scene as run_scene() does; `replay`: a log that is repeated instead of its steps; empty: none.
void run_file(const std::string& scene, const std::string& replay, const RunOptions& options, const Console& console);

/// Runs each scene, `at_once` of them beside each other, with the bits that it has alone; 0: one. Threads of the CPU
/// that are not asked for are shared out. What becomes of each is printed when it has ended; one that fails does not
/// keep the others from being run. Throws Error for outputs that several would write and scenes that are no files,
/// before anything is run, and Failure when one has failed.
void run_several(const std::vector<std::string>& scenes, int at_once, const RunOptions& options,
                 const Console& console);

}  // namespace simplexseg
