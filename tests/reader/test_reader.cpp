// SPDX-License-Identifier: Apache-2.0
// Worker process for tests: it crashes, loops, allocates or sends invalid data on request.
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "core/error.h"
#include "io/dicom/dicom_requests.h"
#include "io/platform/run_worker.h"
#include "reader/test_requests.h"

namespace {

using namespace simplexseg;
using Path = std::filesystem::path;

std::string echo(const Path&, const std::string& text) { return text; }

std::string fail(const Path&, const std::string& manner) {
  if (manner == "abort") std::abort();
  if (manner == "crash") ::raise(SIGSEGV);
  if (manner == "kill") ::raise(SIGKILL);
  if (manner == "exit") std::exit(0);
  if (manner == "throw") throw std::runtime_error("its own reason.");
  if (manner == "throw number") throw 1;
  if (manner == "error") throw Error("cannot read it", "a cause", "do this");
  if (manner == "memory") throw std::bad_alloc();
  if (manner == "sleep") ::sleep(3600);
  if (manner == "print") ::puts("output of a library");
  if (manner == "garbage") {
    const std::string noise(4096, '\xa5');
    ::send(kWorkerChannel, noise.data(), noise.size(), 0);
  }
  if (manner == "large") {
    const FrameHead head{.kind = FrameKind::Result, .bytes = std::uint64_t(1) << 60};
    ::send(kWorkerChannel, &head, sizeof head, 0);
  }
  if (manner == "loop") {
    for (std::atomic<unsigned> n = 0;; ++n) {
    }
  }
  return "still running";
}

bool allocate(const Path&, const std::uint64_t& bytes) {
  void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return false;
  ::munmap(memory, bytes);
  return true;
}

std::string leave_file(const Path&) {
  const std::string name = std::string(std::getenv("TMPDIR")) + "/left";
  std::ofstream(name) << "over";
  return name;
}

void send_then_fail(ResponseWriter& response, const Path& path, const std::uint64_t& count, const std::string& manner) {
  const std::string bytes(count, 'a');
  response.data(bytes.data(), bytes.size());
  fail(path, manner);
}

/// Crashes for files that begin with "crash".
std::vector<DicomFileScan> scan_files(const Path& first, const std::vector<Path>& files) {
  for (const Path& file : files)
    if (file.filename().string().starts_with("crash")) std::abort();
  return in_reader::scan_dicom_files(first, files);
}

}  // namespace

int main(int argc, char** argv) {
  RequestTable table;
  add_request(table, test::kEcho, echo);
  add_request(table, test::kFail, fail);
  add_request(table, test::kAllocate, allocate);
  add_request(table, test::kLeaveFile, leave_file);
  add_stream(table, test::kSend, send_then_fail);
  add_request(table, kDicomHeaders, scan_files);
  return run_worker(argc, argv, kReaderProgram, table);
}
