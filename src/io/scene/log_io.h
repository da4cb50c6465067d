// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "session/command.h"

namespace simplexseg {

/// Largest number of steps of a scene, or of all entries of a log together.
inline constexpr int kMaxSteps = 1000000000;

/// Contents of a log file: docs/scene-format.md, "Logs".
struct LogFile {
  std::vector<LogEntry> log;
  int trailing_steps;
  std::string scene;  ///< scene of the log; empty if not given
};
/// Reads a log file. Throws Error if it is not a log, a command has an unknown name, key or value, or the log has more
/// than kMaxSteps steps.
LogFile read_log(const std::filesystem::path& path);
/// Writes a log file. `scene`: name of the scene, for information only; a replay may use another scene.
void write_log(const std::filesystem::path& path, const std::vector<LogEntry>& log, int trailing_steps,
               const std::string& scene = "");

class JsonInput;

/// JSON of one command, with the keys of a log entry except `after_steps`.
std::string command_text(const Command& command);
/// Reads one command. The file from which an added mesh starts is not read. Throws Error for an unknown name, key or
/// value.
Command read_command(const JsonInput& input);

}  // namespace simplexseg
