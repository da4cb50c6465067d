// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace simplexseg {

/// Largest request line and headers, bytes.
inline constexpr std::size_t kMaxHeaderBytes = 1 << 16;

/// Connection of a client, limited in time and in the size of the headers. Does not own the socket.
class ClientConnection {
 public:
  /// `stopped`: ends all waiting as soon as it is true.
  ClientConnection(int socket, const std::atomic<bool>& stopped) : socket_(socket), stopped_(stopped) {}

  /// Reads up to `size` bytes. Returns 0 at the end of the data, and -1 when the connection failed, the headers are too
  /// large, or the client is too slow: 10 s for the headers, 30 s without data for the body, and, after its first 30 s,
  /// fewer than 16 KiB/s in the mean.
  std::ptrdiff_t read(char* to, std::size_t size);
  /// Writes up to `size` bytes. Returns -1 when the connection failed or the client receives nothing for 30 s.
  std::ptrdiff_t write(const char* from, std::size_t size);
  /// Ends the response. After complete headers, discards what the client still sends, for at most 5 s: it would
  /// otherwise lose the response to a request whose body was not read.
  void finish();
  int socket() const { return socket_; }

 private:
  bool wait(short events, double deadline_s);
  bool refill();
  bool count_header(const char* bytes, std::size_t size);

  const int socket_;
  const std::atomic<bool>& stopped_;
  char buffer_[16384];
  std::size_t begin_ = 0, end_ = 0;  ///< range of unread data in the buffer
  std::size_t header_bytes_ = 0, matched_ = 0;
  std::uint64_t body_bytes_ = 0;
  bool in_headers_ = true;
  double header_deadline_s_ = -1;
};

}  // namespace simplexseg
