// SPDX-License-Identifier: Apache-2.0
// Messages between the program and a worker process on a socket. A request is a RequestHead, the packed name and
// arguments, and the attachments, whose sizes the arguments state. The response is any number of frames with data or
// progress, and one frame with the result or a failure.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "io/platform/worker_limits.h"

namespace simplexseg {

constexpr int kWorkerChannel = 3;       ///< file descriptor of the socket in the worker process
constexpr int kWorkerIdleSeconds = 30;  ///< time without a request after which the worker process exits
constexpr int kExitOtherVersion = 3;    ///< exit status of a worker process of another version
constexpr std::uint32_t kFrameMark = 0x52445331;

struct RequestHead {
  std::uint64_t bytes = 0;  ///< size of the packed request
  WorkerLimits limits;
};

enum class FrameKind : std::uint32_t {
  Data,     ///< part of a stream of bytes
  Result,   ///< packed result, the last frame
  Failure,  ///< reason why the file cannot be read, the last frame
  Error,    ///< complete text of an Error, the last frame
  Progress  ///< packed state of the work, at any time before the last frame
};

struct FrameHead {
  std::uint32_t mark = kFrameMark;
  FrameKind kind = FrameKind::Data;
  std::uint64_t bytes = 0;
};

/// Sends or receives `bytes` bytes. `wait` is called with POLLIN or POLLOUT when the socket is not ready; it returns
/// false to stop. Returns false when it stopped or the other process has closed the socket.
bool send_bytes(int socket, const void* from, std::size_t bytes, const std::function<bool(short)>& wait);
bool receive_bytes(int socket, void* to, std::size_t bytes, const std::function<bool(short)>& wait);

/// Writer of a response; for use in the worker process, which ends when the program has closed the socket.
class ResponseWriter {
 public:
  explicit ResponseWriter(int socket) : socket_(socket) {}
  void send(FrameKind kind, const void* from, std::size_t bytes);
  void data(const void* from, std::size_t bytes) { send(FrameKind::Data, from, bytes); }
  void text(FrameKind kind, const std::string& text) { send(kind, text.data(), text.size()); }

 private:
  int socket_;
};

/// Returns the reason of a failure in the worker process, `crash` for an unknown exception. To be called in a handler
/// of any exception.
std::string reason_of_exception(const char* crash);

}  // namespace simplexseg
