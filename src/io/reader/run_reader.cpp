// SPDX-License-Identifier: Apache-2.0
#include "io/reader/run_reader.h"

#include <poll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "core/error.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void end_with(int status, const fs::path& temporary_folder) {
  std::error_code ignored;
  if (temporary_folder.filename().string().starts_with("simplexseg-")) fs::remove_all(temporary_folder, ignored);
  ::_exit(status);
}

/// Ends this process when the other process has closed the socket, even during a request.
void watch_channel(const fs::path& temporary_folder) {
  pollfd closed{kReaderChannel, POLLRDHUP, 0};
  while (::poll(&closed, 1, -1) < 0) {
  }
  end_with(1, temporary_folder);
}

/// Returns the size of the address space of this process, bytes; 0 when unknown. It is larger than the memory in use.
std::size_t address_space() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void set_soft_limit(__rlimit_resource resource, std::uint64_t value) {
  rlimit limit{};
  ::getrlimit(resource, &limit);
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

void apply_limits(const RequestHead& head) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto used_seconds = static_cast<std::uint64_t>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec);
  constexpr std::uint64_t rounding = 2;  // fractions of seconds of both times
  set_soft_limit(RLIMIT_CPU, used_seconds + rounding + head.cpu_seconds);
  set_soft_limit(RLIMIT_AS, RLIM_INFINITY);
  if (const std::size_t now = address_space(); now > 0) set_soft_limit(RLIMIT_AS, now + head.memory_bytes);
}

void respond(const RequestTable& table, const std::string& request, ResponseWriter& response) {
  constexpr std::size_t max_message = 2000;
  try {
    Unpacker from(request);
    const auto found = table.find(next_value<std::string>(from));
    if (found == table.end()) throw std::runtime_error("the request is unknown");
    found->second(from, response);
  } catch (const Error& error) {
    response.text(FrameKind::Error, std::string(error.what()).substr(0, max_message));
  } catch (const std::bad_alloc&) {
    response.text(FrameKind::Failure, "it is damaged (reading it exceeds the limit of memory)");
  } catch (const std::exception& exception) {
    response.text(FrameKind::Failure, message_of(exception).substr(0, max_message));
  } catch (...) {
    response.text(FrameKind::Failure, "it is damaged (the library that reads it failed)");
  }
}

bool wait_for_request(short event) {
  pollfd request{kReaderChannel, event, 0};
  int ready = 0;
  do {
    ready = ::poll(&request, 1, 1000 * kReaderIdleSeconds);
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

}  // namespace

int run_reader(int argc, char** argv, const RequestTable& table) {
  struct stat channel {};
  if (argc != 3 || ::fstat(kReaderChannel, &channel) != 0 || !S_ISSOCK(channel.st_mode)) {
    std::fputs("simplexseg-reader: it is started by the other programs of SimplexSeg, not by hand\n", stderr);
    return 2;
  }
  if (std::string(argv[1]) != SIMPLEXSEG_VERSION) ::_exit(kExitOtherVersion);
  std::atexit([] { ::_exit(1); });  // no other exit handler runs if a library calls exit()
  std::signal(SIGPIPE, SIG_IGN);
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const fs::path temporary_folder = argv[2];
  std::thread(watch_channel, temporary_folder).detach();
  ResponseWriter response(kReaderChannel);
  RequestHead head;
  std::string request;
  while (receive_bytes(kReaderChannel, &head, sizeof head, wait_for_request)) {
    request.resize(head.bytes);
    if (!receive_bytes(kReaderChannel, request.data(), request.size(), wait_for_request)) break;
    apply_limits(head);
    respond(table, request, response);
  }
  end_with(0, temporary_folder);
}

}  // namespace simplexseg
