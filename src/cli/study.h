// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "cli/commands.h"

namespace simplexseg {

// Each adds one study, in a file of its own.
void add_study_error_time(const Subcommand& studies, Action& action);
void add_study_stability(const Subcommand& studies, Action& action);

/// Writes a table or a list, whole or not at all. Throws Error as AtomicFile.
void write_text(const std::filesystem::path& path, const std::string& text);
/// Makes the folder of a study's results. Throws Error where it cannot.
void make_result_folder(const std::string& folder);

}  // namespace simplexseg
