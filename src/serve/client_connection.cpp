// SPDX-License-Identifier: Apache-2.0
#include "serve/client_connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string_view>

namespace simplexseg {
namespace {

constexpr double kHeaderTimeout_s = 10, kIdleTimeout_s = 30, kFinishTimeout_s = 5;
constexpr double kMinBytesPerSecond = 16384;  // of a body, after the first kIdleTimeout_s
constexpr int kPollMs = 100;                  // between two checks of `stopped`
constexpr std::string_view kEndOfHeaders = "\r\n\r\n";

double clock_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

bool ClientConnection::wait(short events, double deadline_s) {
  while (!stopped_ && clock_s() < deadline_s) {
    pollfd one{socket_, events, 0};
    const int ready = ::poll(&one, 1, kPollMs);
    if (ready > 0) return true;  // also for a failure, which the next call reports
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

bool ClientConnection::refill() {
  const double now = clock_s();
  if (header_deadline_s_ < 0) header_deadline_s_ = now + kHeaderTimeout_s;
  const double body_deadline_s =
      header_deadline_s_ + kIdleTimeout_s + static_cast<double>(body_bytes_) / kMinBytesPerSecond;
  if (!wait(POLLIN, in_headers_ ? header_deadline_s_ : std::min(now + kIdleTimeout_s, body_deadline_s))) return false;
  const ssize_t count = ::recv(socket_, buffer_, sizeof buffer_, 0);
  if (count < 0) return false;
  begin_ = 0, end_ = static_cast<std::size_t>(count);
  if (!in_headers_) body_bytes_ += end_;
  return true;
}

/// Counts bytes of the headers up to the empty line that ends them. Returns false if there are too many.
bool ClientConnection::count_header(const char* bytes, std::size_t size) {
  for (std::size_t b = 0; b < size && in_headers_; ++b) {
    if (++header_bytes_ > kMaxHeaderBytes) return false;
    if (bytes[b] == kEndOfHeaders[matched_])
      ++matched_;
    else
      matched_ = bytes[b] == '\r' ? 1 : 0;
    in_headers_ = matched_ < kEndOfHeaders.size();
  }
  return true;
}

std::ptrdiff_t ClientConnection::read(char* to, std::size_t size) {
  if (begin_ == end_ && !refill()) return -1;
  const std::size_t count = std::min(size, end_ - begin_);
  if (!count_header(buffer_ + begin_, count)) return -1;
  std::memcpy(to, buffer_ + begin_, count);
  begin_ += count;
  return static_cast<std::ptrdiff_t>(count);
}

std::ptrdiff_t ClientConnection::write(const char* from, std::size_t size) {
  if (!wait(POLLOUT, clock_s() + kIdleTimeout_s)) return -1;
  return ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
}

void ClientConnection::finish() {
  ::shutdown(socket_, SHUT_WR);
  if (in_headers_) return;
  const double deadline = clock_s() + kFinishTimeout_s;
  while (wait(POLLIN, deadline) && ::recv(socket_, buffer_, sizeof buffer_, MSG_DONTWAIT) > 0) {
  }
}

}  // namespace simplexseg
