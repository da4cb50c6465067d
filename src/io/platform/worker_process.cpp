// SPDX-License-Identifier: Apache-2.0
#include "io/platform/worker_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/error.h"
#include "core/system_error.h"

namespace simplexseg {
namespace {

/// Returns the size of the address space of this process, bytes; 0 when unknown. It is larger than the memory in use.
std::size_t address_space() {
  std::size_t pages = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void set_limit(__rlimit_resource resource, std::size_t limit_value) {
  const rlimit limit{limit_value, limit_value};
  ::setrlimit(resource, &limit);
}

[[noreturn]] void run_worker(const WorkerLimits& limits, const char* folder, const std::function<void(int)>& work,
                             int pipe) {
  std::atexit([] { ::_exit(1); });  // no other exit handler runs if a library calls exit()
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGXCPU, SIGTERM}) std::signal(signal, SIG_DFL);
  std::signal(SIGPIPE, SIG_IGN);
  const int null_device = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null_device, stream);
  ::setenv("TMPDIR", folder, 1);
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_CPU, static_cast<std::size_t>(limits.cpu_seconds));
  if (const std::size_t now = address_space(); now > 0) set_limit(RLIMIT_AS, now + limits.memory_bytes);
  try {
    work(pipe);
  } catch (...) {
    ::_exit(1);
  }
  ::_exit(0);
}

}  // namespace

WorkerProcess::WorkerProcess(const WorkerLimits& limits, const std::function<void(int pipe)>& work)
    : idle_timeout_ms_(1000 * std::min(limits.idle_timeout_s(), 1000000)) {
  const auto fail = [] {
    throw Error("cannot start the worker process that reads the file", system_error_text(errno),
                "close other programs");
  };
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail();
  pipe_ = ends[0];
  std::fflush(nullptr);
  worker_ = ::fork();
  if (worker_ == 0) run_worker(limits, folder_.path().c_str(), work, ends[1]);
  const int why = errno;
  ::close(ends[1]);
  if (worker_ > 0) return;
  ::close(pipe_);
  errno = why;
  fail();
}

WorkerProcess::~WorkerProcess() {
  ::close(pipe_);
  ::kill(worker_, SIGKILL);
  while (::waitpid(worker_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

bool WorkerProcess::read(void* to, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    pollfd request{pipe_, POLLIN, 0};
    const int ready = ::poll(&request, 1, idle_timeout_ms_);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t count = ::read(pipe_, static_cast<char*>(to) + done, std::min<std::size_t>(bytes - done, 1 << 20));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}

void write_to_parent(int pipe, const void* from, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t count = ::write(pipe, static_cast<const char*>(from) + done, bytes - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) ::_exit(1);
    done += static_cast<std::size_t>(count);
  }
}

}  // namespace simplexseg
