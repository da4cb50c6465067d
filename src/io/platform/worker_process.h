// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <functional>

#include "io/platform/temporary_folder.h"

namespace simplexseg {

/// Limits of a worker process.
struct WorkerLimits {
  std::size_t memory_bytes = 256 << 20;  ///< address space in addition to that of the parent at the fork
  int cpu_seconds = 6;                   ///< processor time, s
  int min_idle_timeout_s = 60;           ///< idle timeout without the part for the processor time, s
  /// Returns the longest time without output after which the worker is considered blocked, s. It is much longer than
  /// the processor time, because other programs can slow the worker down.
  int idle_timeout_s() const { return min_idle_timeout_s + 10 * cpu_seconds; }
};

/// Forked process that runs `work` and exits. It isolates libraries that crash, loop or exhaust memory on damaged
/// files. `work` writes its results to the given pipe. The standard streams of the worker are /dev/null, and its TMPDIR
/// is a folder that is deleted with this object. `work` must not acquire a lock such as QuietLibraries, because the
/// thread that holds the lock does not exist in the forked process. The constructor throws Error when the process
/// cannot be started.
class WorkerProcess {
 public:
  WorkerProcess(const WorkerLimits& limits, const std::function<void(int pipe)>& work);
  ~WorkerProcess();  ///< kills the worker if it still runs
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// Waits for `bytes` bytes from the worker. Returns false when the worker ends or fails before, or exceeds the idle
  /// timeout.
  bool read(void* to, std::size_t bytes);

 private:
  TemporaryFolder folder_;
  pid_t worker_ = -1;
  int pipe_ = -1;
  int idle_timeout_ms_;
};

/// Writes all bytes to the pipe; for use in `work`. Ends the worker when the parent has closed the pipe.
void write_to_parent(int pipe, const void* from, std::size_t bytes);

}  // namespace simplexseg
