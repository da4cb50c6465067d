// SPDX-License-Identifier: Apache-2.0
// Limits of a worker process (worker_process.h), for each request or each file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace simplexseg {

struct WorkerLimits {
  std::size_t memory_bytes = 256 << 20;  ///< address space in addition to that of the process when the limits are set
  int cpu_seconds = 6;                   ///< processor time, s
  int min_idle_timeout_s = 60;           ///< idle timeout without the part for the processor time, s
  /// Returns the longest time without output after which the process is considered blocked, s. It is much longer than
  /// the processor time, because other programs can slow the process down.
  int idle_timeout_s() const { return min_idle_timeout_s + 10 * cpu_seconds; }
};

/// Returns limits for files of this size that are read as a whole: more memory and time for large files.
WorkerLimits limits_for_bytes(std::uintmax_t bytes);
WorkerLimits limits_for_file(const std::filesystem::path& file);

/// Limits memory and processor time of this process, which is a worker process, from now on.
void limit_this_process(const WorkerLimits& limits);
/// Grants the whole processor time of the last limits again, for the next of several files.
void restart_processor_time();

}  // namespace simplexseg
