// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "session/command.h"

namespace simplexseg {

/// The most steps that a scene may have taken, or that the entries of a log ask for together.
inline constexpr int kMostSteps = 1000000000;

/// A log file, read: docs/scene-format.md, "Logs".
struct LogFile {
  std::vector<LogEntry> log;
  int trailing_steps;
  std::string scene;  ///< empty when the file does not say
};
/// Throws Error when the file is no log, a command in it has an unknown name, key or value, or more than kMostSteps
/// steps are asked for.
LogFile read_log(const std::filesystem::path& path);
/// `scene` says in the file what the log belongs to; replay applies it to the scene at hand all the same.
void write_log(const std::filesystem::path& path, const std::vector<LogEntry>& log, int trailing_steps,
               const std::string& scene = "");

class JsonInput;

/// One command as JSON, with the keys that it has in a log but `after_steps`.
std::string command_text(const Command& command);
/// Takes it. What an added mesh starts from is named, not read. Throws Error for an unknown name, key or value.
Command read_command(const JsonInput& input);

}  // namespace simplexseg
