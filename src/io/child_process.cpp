// SPDX-License-Identifier: Apache-2.0
#include "io/child_process.h"

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

namespace simplexseg {
namespace {

/// Address space of this process, which is more than what it uses.
std::size_t address_space() {
  std::size_t pages = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void set_limit(__rlimit_resource resource, std::size_t most) {
  const rlimit limit{most, most};
  ::setrlimit(resource, &limit);
}

[[noreturn]] void run_child(const ChildLimits& limits, const char* folder, const std::function<void(int)>& work,
                            int pipe) {
  std::atexit([] { ::_exit(1); });  // a library that ends the program runs nothing of ours
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGXCPU, SIGTERM}) std::signal(signal, SIG_DFL);
  std::signal(SIGPIPE, SIG_IGN);
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
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

ChildProcess::ChildProcess(const ChildLimits& limits, const std::function<void(int pipe)>& work)
    : silent_ms_(1000 * std::min(limits.silent_seconds(), 1000000)) {
  const auto refuse = [](const char* what) {
    throw Error("cannot read the file in a process of its own", std::string(what) + ": " + std::strerror(errno),
                "close other programs");
  };
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) refuse("no pipe");
  pipe_ = ends[0];
  std::fflush(nullptr);
  child_ = ::fork();
  if (child_ == 0) run_child(limits, folder_.path().c_str(), work, ends[1]);
  const int why = errno;
  ::close(ends[1]);
  if (child_ > 0) return;
  ::close(pipe_);
  errno = why;
  refuse("no child process");
}

ChildProcess::~ChildProcess() {
  ::close(pipe_);
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

bool ChildProcess::read(void* to, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    pollfd wanted{pipe_, POLLIN, 0};
    const int ready = ::poll(&wanted, 1, silent_ms_);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t got = ::read(pipe_, static_cast<char*>(to) + done, std::min<std::size_t>(bytes - done, 1 << 20));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    done += static_cast<std::size_t>(got);
  }
  return true;
}

void write_to_parent(int pipe, const void* from, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t put = ::write(pipe, static_cast<const char*>(from) + done, bytes - done);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) ::_exit(1);
    done += static_cast<std::size_t>(put);
  }
}

}  // namespace simplexseg
