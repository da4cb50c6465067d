// SPDX-License-Identifier: Apache-2.0
#include "io/platform/quiet_libraries.h"

#include <fcntl.h>
#include <gdcmTrace.h>
#include <unistd.h>

#include <csetjmp>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <mutex>

#include "io/platform/files.h"

namespace simplexseg {
namespace {

std::recursive_mutex mutex;
int depth = 0;
int saved_stderr = -1;

thread_local sigjmp_buf* jump_target = nullptr;

/// Handler of SIGABRT, called in the thread that called abort(). Without a jump target, the default handler ends the
/// program.
void on_abort(int signal) {
  if (jump_target) siglongjmp(*jump_target, 1);
  std::signal(signal, SIG_DFL);
}

/// Scope in which on_abort() handles abort(). Only one thread at a time is in such a scope: the one in a scope of
/// QuietLibraries, or the single thread of a worker process.
class AbortTrap {
 public:
  AbortTrap() {
    struct sigaction trap {};
    trap.sa_handler = on_abort;
    ::sigaction(SIGABRT, &trap, &before_);
  }
  ~AbortTrap() { ::sigaction(SIGABRT, &before_, nullptr); }
  AbortTrap(const AbortTrap&) = delete;
  AbortTrap& operator=(const AbortTrap&) = delete;

 private:
  struct sigaction before_ {};
};

}  // namespace

QuietLibraries::QuietLibraries() {
  mutex.lock();
  if (depth++ > 0) return;
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  std::fflush(stderr);
  saved_stderr = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  const int null_device = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (saved_stderr >= 0 && null_device >= 0) ::dup2(null_device, STDERR_FILENO);
  if (null_device >= 0) ::close(null_device);
}

QuietLibraries::~QuietLibraries() {
  if (--depth == 0) {
    std::fflush(stderr);
    std::cerr.flush();
    if (saved_stderr >= 0) {
      ::dup2(saved_stderr, STDERR_FILENO);
      ::close(saved_stderr);
    }
    saved_stderr = -1;
  }
  mutex.unlock();
}

void with_stderr_enabled(const std::function<void()>& f) {
  const std::lock_guard lock(mutex);
  f();
}

void without_aborting(const std::function<void()>& f) {
  const AbortTrap trap;
  sigjmp_buf here;
  sigjmp_buf* const before = jump_target;
  if (sigsetjmp(here, 1) != 0) {
    jump_target = before;
    throw std::runtime_error("it is damaged (an assertion of the DICOM library failed)");
  }
  jump_target = &here;
  try {
    f();
  } catch (...) {
    jump_target = before;
    throw;
  }
  jump_target = before;
}

std::string message_of(const std::exception& exception) {
  std::string line = one_line(exception.what());
  while (!line.empty() && (line.back() == '.' || line.back() == ' ')) line.pop_back();
  return line.empty() ? "its contents are not valid" : line;
}

}  // namespace simplexseg
