// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <functional>

#include "io/platform/temporary_folder.h"

namespace simplexseg {

/// Limits of a worker process, in addition to the memory that the parent uses when it forks.
struct WorkerLimits {
  std::size_t memory_bytes = 256 << 20;
  int cpu_seconds = 6;  ///< processor time
  int min_idle_timeout_s = 60;
  /// Longest time without output, for a worker that blocks. It is much longer than the processor time, because other
  /// programs can slow the worker down.
  int idle_timeout_s() const { return min_idle_timeout_s + 10 * cpu_seconds; }
};

/// Forked process that runs `work` and exits. It isolates libraries that crash, loop or exhaust memory on damaged
/// files. `work` writes its results to the given pipe; its standard streams are /dev/null, and its TMPDIR is deleted
/// with this object. `work` must not acquire a lock such as QuietLibraries: the thread that holds it does not exist
/// in the forked process. The constructor throws Error when the process cannot be started.
class WorkerProcess {
 public:
  WorkerProcess(const WorkerLimits& limits, const std::function<void(int pipe)>& work);
  ~WorkerProcess();  ///< kills the worker if it still runs
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// Waits for `bytes` bytes from the worker. Returns false when it ended or failed before, or exceeded the idle
  /// timeout.
  bool read(void* to, std::size_t bytes);

 private:
  TemporaryFolder folder_;
  pid_t worker_ = -1;
  int pipe_ = -1;
  int idle_timeout_ms_;
};

/// Writes all bytes to the pipe; for use in `work`. Ends the worker when the pipe is closed.
void write_to_parent(int pipe, const void* from, std::size_t bytes);

}  // namespace simplexseg
