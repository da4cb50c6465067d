// SPDX-License-Identifier: Apache-2.0
#include "io/quiet_libraries.h"

#include <fcntl.h>
#include <gdcmTrace.h>
#include <unistd.h>

#include <csetjmp>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <mutex>

#include "io/files.h"

namespace simplexseg {
namespace {

std::recursive_mutex mutex;
int depth = 0;
int kept_stderr = -1;

thread_local sigjmp_buf* armed = nullptr;

/// Of the thread that called abort(), before the program ends. One that is not armed goes on to end it.
void leave(int signal) {
  if (armed) siglongjmp(*armed, 1);
  std::signal(signal, SIG_DFL);
}

/// While one lives, abort() goes to leave(). One thread at a time has them, since it holds QuietLibraries, or is the
/// only one of a child process.
class AbortTrap {
 public:
  AbortTrap() {
    struct sigaction trap {};
    trap.sa_handler = leave;
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
  kept_stderr = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (kept_stderr >= 0 && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
  if (nowhere >= 0) ::close(nowhere);
}

QuietLibraries::~QuietLibraries() {
  if (--depth == 0) {
    std::fflush(stderr);
    std::cerr.flush();
    if (kept_stderr >= 0) {
      ::dup2(kept_stderr, STDERR_FILENO);
      ::close(kept_stderr);
    }
    kept_stderr = -1;
  }
  mutex.unlock();
}

void while_heard(const std::function<void()>& f) {
  const std::lock_guard lock(mutex);
  f();
}

void without_aborting(const std::function<void()>& f) {
  const AbortTrap trap;
  sigjmp_buf here;
  sigjmp_buf* const before = armed;
  if (sigsetjmp(here, 1) != 0) {
    armed = before;
    throw std::runtime_error("it is damaged (an assumption of the reader does not hold)");
  }
  armed = &here;
  try {
    f();
  } catch (...) {
    armed = before;
    throw;
  }
  armed = before;
}

std::string plain_words(const std::exception& exception) {
  std::string line = one_line(exception.what());
  while (!line.empty() && (line.back() == '.' || line.back() == ' ')) line.pop_back();
  return line.empty() ? "the file cannot be understood" : line;
}

}  // namespace simplexseg
