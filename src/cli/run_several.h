// SPDX-License-Identifier: Apache-2.0
// Runs several scenes in one process, which share the device, its context and the start of the program.
#pragma once
#include <string>
#include <vector>

#include "cli/run_scene.h"

namespace simplexseg {

/// Placeholder for the name of the scene in output names.
inline constexpr const char* kScenePlaceholder = "{name}";

/// Returns the options with the placeholder replaced by the name of the scene: its file name without the extension.
RunOptions options_for(const std::string& scene, const RunOptions& options);

/// Reads a scene and runs it with run_scene(). `replay`: log that replaces the steps of the scene; empty: none.
void run_file(const std::string& scene, const std::string& replay, const RunOptions& options, const Console& console);

/// Runs the scenes, `at_once` (at least 1) in parallel; each result is identical to that of a single run. CPU cores are
/// divided among the runs unless a number of threads is set. Prints the result of each scene when it ends; a failed
/// scene does not stop the others. Throws Error before any run if several scenes would write one output or a scene file
/// is missing, and Failure after all runs if a scene failed.
void run_several(const std::vector<std::string>& scenes, int at_once, const RunOptions& options,
                 const Console& console);

}  // namespace simplexseg
