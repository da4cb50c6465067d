// SPDX-License-Identifier: Apache-2.0
#include "io/quiet_libraries.h"

#include <fcntl.h>
#include <gdcmTrace.h>
#include <unistd.h>

#include <cassert>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <mutex>

#include "io/files.h"

namespace simplexseg {
namespace {

std::recursive_mutex mutex;
int depth = 0;
int kept_stderr = -1;

thread_local std::jmp_buf* armed = nullptr;
thread_local char broken_assertion[200];

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
  std::jmp_buf here;
  std::jmp_buf* const before = armed;
  if (setjmp(here) != 0) {
    armed = before;
    throw std::runtime_error(std::string("it is damaged (") + broken_assertion + ")");
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

/// glibc's, in front of which this one comes for the shared libraries too: see without_aborting().
extern "C" void __assert_fail(const char* assertion, const char* file, unsigned line, const char* function) noexcept {
  using simplexseg::armed;
  if (armed) {
    std::snprintf(simplexseg::broken_assertion, sizeof simplexseg::broken_assertion, "broken assumption: %s",
                  assertion);
    std::longjmp(*armed, 1);
  }
  std::fprintf(stderr, "%s:%u: %s: Assertion `%s' failed.\n", file, line, function ? function : "?", assertion);
  std::abort();
}
