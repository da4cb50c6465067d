// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <functional>

#include "io/temporary_folder.h"

namespace simplexseg {

/// What a child process may use beyond what it begins with.
struct ChildLimits {
  std::size_t memory_bytes = 256 << 20;
  int cpu_seconds = 6;
  int least_silent_seconds = 60;
  /// How long it may say nothing, for one that waits for what never comes: much more than it may compute, since the
  /// machine is shared.
  int silent_seconds() const { return least_silent_seconds + 10 * cpu_seconds; }
};

/// A copy of this process that does `work` and ends, for libraries that a damaged file can make crash, loop or take all
/// memory: only the child suffers. `work` writes what it finds to the pipe that it is given. It prints nothing and
/// leaves no trace but in `folder`, which is its temporary folder and goes with it. It must take no lock
/// (QuietLibraries is one): whoever held it is not there to give it back. Throws Error when there can be no child.
class ChildProcess {
 public:
  ChildProcess(const ChildLimits& limits, const std::function<void(int pipe)>& work);
  ~ChildProcess();  ///< ends the child if it still runs
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits for so many bytes of the child. False when it ended or failed before, or said nothing for too long.
  bool read(void* to, std::size_t bytes);

 private:
  TemporaryFolder folder_;
  pid_t child_ = -1;
  int pipe_ = -1;
  int silent_ms_;
};

/// For `work`: writes all of it, or ends the child where nobody listens any more.
void write_to_parent(int pipe, const void* from, std::size_t bytes);

}  // namespace simplexseg
