// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "session/command.h"

namespace simplexseg {

/// Largest number of steps of a scene, and of a log in total.
inline constexpr int kMaxSteps = 1000000000;

/// Contents of a log file (docs/scene-format.md, "Logs").
struct LogFile {
  std::vector<LogEntry> log;
  int trailing_steps;  ///< steps after the last entry
  std::string scene;   ///< name of the scene, for information only; empty if not given
};
/// Reads a log file and the files from which added meshes start. Throws Error if the file is not a log, a command has
/// an unknown name, key or value, the log has more than kMaxSteps steps, or the start of a mesh cannot be read.
LogFile read_log(const std::filesystem::path& path);
/// Writes a log file through a temporary file. `scene`: name of the scene, for information only; a replay may use
/// another scene. Throws Error for a failed write or a name that is not UTF-8.
void write_log(const std::filesystem::path& path, const std::vector<LogEntry>& log, int trailing_steps,
               const std::string& scene = "");

class JsonInput;

/// JSON text of one command: a log entry without `after_steps`.
std::string command_text(const Command& command);
/// Reads one command, but not the file from which an added mesh starts. Throws Error for an unknown name, key or value.
Command read_command(const JsonInput& input);

}  // namespace simplexseg
