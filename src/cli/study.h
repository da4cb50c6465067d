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

/// Writes a text file atomically. Throws Error like AtomicFile.
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace simplexseg
