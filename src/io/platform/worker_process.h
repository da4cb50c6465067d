// SPDX-License-Identifier: Apache-2.0
// Requests to worker processes: simplexseg-reader, which calls the libraries that can crash, abort, loop or exhaust
// memory on damaged files (GDCM and libminc), and simplexseg-register, which calls ITK. The processes are started when
// needed, serve one request at a time and are kept for the next requests of the program. worker_request.h has the typed
// interface.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "io/platform/worker_limits.h"
#include "io/platform/worker_program.h"

namespace simplexseg {

/// Failure because of the file: the reason that the worker process found, or its crash, or a limit. The text has no
/// path.
class WorkerFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Failure without any relation to the file: the worker program is missing, cannot be started, or was killed.
class WorkerUnavailable : public Error {
 public:
  using Error::Error;
};

/// Program that serves a request, and what the request needs in addition to its packed arguments.
struct WorkerCall {
  const WorkerProgram& program = kReaderProgram;
  std::vector<std::span<const std::byte>> attachments{};  ///< sent after the arguments; valid as long as the request
  std::function<void(std::string_view)> on_progress{};    ///< called with each packed state of the work
};

class WorkerProcess;

/// Request that is being served by a worker process. The destructor kills the process unless the response is complete.
/// All functions throw WorkerFailure, WorkerUnavailable, or Cancelled after a cancellation of the bound LoadProgress.
class WorkerRequest {
 public:
  /// Starts a process if none is idle, and sends the request. If an idle process is killed before it responds, the
  /// request is repeated once by a new process. `packed`: name and arguments. `file`: file to be read, for messages.
  WorkerRequest(std::string packed, std::filesystem::path file, const WorkerLimits& limits, WorkerCall call = {});
  ~WorkerRequest();
  WorkerRequest(const WorkerRequest&) = delete;
  WorkerRequest& operator=(const WorkerRequest&) = delete;

  /// Waits for the next `bytes` bytes of the stream.
  void read(void* to, std::size_t bytes);
  /// Waits for the packed result, which ends the response.
  std::string finish();

 private:
  bool wait(short event) const;
  bool send_request();
  void repeat_or_fail();
  void receive(void* to, std::size_t bytes);
  std::uint64_t next_frame(bool data);
  [[noreturn]] void fail_by_garbage();

  std::string packed_;
  std::filesystem::path file_;
  WorkerLimits limits_;
  WorkerCall call_;
  int idle_timeout_ms_;
  std::uint64_t frame_left_ = 0;  ///< bytes of the current data frame that are not yet read
  bool can_repeat_ = false;       ///< the process was idle before, and has not responded
  std::unique_ptr<WorkerProcess> process_;
};

/// Starts a process of simplexseg-reader if none is idle, so that it is ready when the next request is made.
void prepare_reader();

/// Ends all idle worker processes and deletes their temporary folders. Without this call the processes exit after
/// kWorkerIdleSeconds, or with the program.
void end_idle_workers();

}  // namespace simplexseg
