// SPDX-License-Identifier: Apache-2.0
#include "io/platform/run_worker.h"

#include <malloc.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "core/error.h"
#include "io/platform/worker_limits.h"

#ifdef SIMPLEXSEG_COVERAGE  // this process never ends by exit(), by which libgcov writes its counters
extern "C" void __gcov_dump();
extern "C" void __gcov_reset();
#endif

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
  pollfd closed{kWorkerChannel, POLLRDHUP, 0};
  while (::poll(&closed, 1, -1) < 0) {
  }
  end_with(1, temporary_folder);
}

void respond(const WorkerProgram& program, const RequestTable& table, const std::string& request,
             ResponseWriter& response) {
  try {
    Unpacker from(request);
    const auto found = table.find(next_value<std::string>(from));
    if (found == table.end()) throw std::runtime_error("the request is unknown");
    found->second(from, response);
  } catch (const Error& error) {
    response.text(FrameKind::Error, error.what());
  } catch (...) {
    response.text(FrameKind::Failure, reason_of_exception(program.crash));
  }
}

bool wait_for_request(short event) {
  pollfd request{kWorkerChannel, event, 0};
  int ready = 0;
  do {
    ready = ::poll(&request, 1, 1000 * kWorkerIdleSeconds);
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

}  // namespace

void receive_attachment(void* to, std::size_t bytes) {
  if (!receive_bytes(kWorkerChannel, to, bytes, wait_for_request)) ::_exit(1);  // the program has closed the socket
}

int run_worker(int argc, char** argv, const WorkerProgram& program, const RequestTable& table) {
  struct stat channel {};
  if (argc != 3 || ::fstat(kWorkerChannel, &channel) != 0 || !S_ISSOCK(channel.st_mode)) {
    std::fputs(program.name, stderr);
    std::fputs(": it is started by the other programs of SimplexSeg, not by hand\n", stderr);
    return 2;
  }
  if (std::string(argv[1]) != SIMPLEXSEG_VERSION) ::_exit(kExitOtherVersion);
  std::atexit([] { ::_exit(1); });  // no other exit handler runs if a library calls exit()
  std::signal(SIGPIPE, SIG_IGN);
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  // Freed memory is kept for the next frame: its return to the system took a fifth of the time of decoding.
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 64 << 20);
  const fs::path temporary_folder = argv[2];
  std::thread(watch_channel, temporary_folder).detach();
  ResponseWriter response(kWorkerChannel);
  RequestHead head;
  std::string request;
  while (receive_bytes(kWorkerChannel, &head, sizeof head, wait_for_request)) {
    request.resize(head.bytes);
    if (!receive_bytes(kWorkerChannel, request.data(), request.size(), wait_for_request)) break;
    limit_this_process(head.limits);
    respond(program, table, request, response);
#ifdef SIMPLEXSEG_COVERAGE
    __gcov_dump();
    __gcov_reset();
#endif
  }
  end_with(0, temporary_folder);
}

}  // namespace simplexseg
