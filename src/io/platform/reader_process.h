// SPDX-License-Identifier: Apache-2.0
// Requests to the worker process simplexseg-reader, which calls the libraries that can crash, abort, loop or exhaust
// memory on damaged files: GDCM and libminc. The processes are started when needed, serve one request at a time and are
// kept for the next requests of the program. reader_request.h has the typed interface.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/error.h"

namespace simplexseg {

/// Limits of one request.
struct ReaderLimits {
  std::size_t memory_bytes = 256 << 20;  ///< address space in addition to that of the process before the request
  int cpu_seconds = 6;                   ///< processor time, s
  int min_idle_timeout_s = 60;           ///< idle timeout without the part for the processor time, s
  /// Returns the longest time without output after which the process is considered blocked, s. It is much longer than
  /// the processor time, because other programs can slow the process down.
  int idle_timeout_s() const { return min_idle_timeout_s + 10 * cpu_seconds; }
};

/// Returns limits for a file that is read as a whole: more memory and time for a large file.
ReaderLimits limits_for_file(const std::filesystem::path& file);

/// Failure because of the file: the reason that the worker process found, or its crash, or a limit. The text has no
/// path.
class ReaderFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Failure without any relation to the file: the program simplexseg-reader is missing, cannot be started, or was
/// killed.
class ReaderUnavailable : public Error {
 public:
  using Error::Error;
};

class ReaderProcess;

/// Request that is being served by a worker process. The destructor kills the process unless the response is complete.
/// All functions throw ReaderFailure, ReaderUnavailable, or Cancelled after a cancellation of the bound LoadProgress.
class ReaderRequest {
 public:
  /// Starts a process if none is idle, and sends the request. If an idle process is killed before it responds, the
  /// request is repeated once by a new process. `packed`: name and arguments. `file`: file to be read, for messages.
  ReaderRequest(std::string packed, std::filesystem::path file, const ReaderLimits& limits);
  ~ReaderRequest();
  ReaderRequest(const ReaderRequest&) = delete;
  ReaderRequest& operator=(const ReaderRequest&) = delete;

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
  ReaderLimits limits_;
  int idle_timeout_ms_;
  std::uint64_t frame_left_ = 0;  ///< bytes of the current data frame that are not yet read
  bool can_repeat_ = false;       ///< the process was idle before, and has not responded
  std::unique_ptr<ReaderProcess> process_;
};

/// Ends all idle worker processes and deletes their temporary folders. Without this call the processes exit after
/// kReaderIdleSeconds, or with the program.
void end_idle_readers();

}  // namespace simplexseg
