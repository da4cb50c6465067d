// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "cli/commands.h"

namespace simplexseg {

// Each function adds one study and has its own source file.
void add_study_error_time(const Subcommand& studies, Action& action);
void add_study_field_error_time(const Subcommand& studies, Action& action);
void add_study_field_stability(const Subcommand& studies, Action& action);
void add_study_stability(const Subcommand& studies, Action& action);

/// Adds the options --backend (auto, cpu or cuda) and --threads (0: all cores).
void add_processor_options(const Subcommand& study, std::string& backend, int& threads);
/// Returns whether a value of --backend chooses CUDA. Throws Error for "cuda" if no device is usable.
bool chooses_cuda(const std::string& backend);

/// Writes a text file atomically. Throws Error like AtomicFile.
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace simplexseg
