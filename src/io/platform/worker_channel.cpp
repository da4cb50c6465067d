// SPDX-License-Identifier: Apache-2.0
#include "io/platform/worker_channel.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <new>

#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMaxTransfer = 1 << 20;  // bytes per system call, so that progress and cancellation are frequent

/// Calls `transfer` until all bytes are transferred.
template <class Transfer>
bool transfer_all(std::size_t bytes, short event, const std::function<bool(short)>& wait, const Transfer& transfer) {
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t count = transfer(done, std::min(bytes - done, kMaxTransfer));
    if (count > 0) {
      done += static_cast<std::size_t>(count);
    } else if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      if (!wait(event)) return false;
    } else if (count == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

bool wait_for_ever(int socket, short event) {
  pollfd request{socket, event, 0};
  return ::poll(&request, 1, -1) > 0 || errno == EINTR;
}

}  // namespace

bool send_bytes(int socket, const void* from, std::size_t bytes, const std::function<bool(short)>& wait) {
  return transfer_all(bytes, POLLOUT, wait, [&](std::size_t at, std::size_t count) {
    return ::send(socket, static_cast<const char*>(from) + at, count, MSG_NOSIGNAL | MSG_DONTWAIT);
  });
}

bool receive_bytes(int socket, void* to, std::size_t bytes, const std::function<bool(short)>& wait) {
  return transfer_all(bytes, POLLIN, wait, [&](std::size_t at, std::size_t count) {
    return ::recv(socket, static_cast<char*>(to) + at, count, MSG_DONTWAIT);
  });
}

void ResponseWriter::send(FrameKind kind, const void* from, std::size_t bytes) {
  const FrameHead head{.kind = kind, .bytes = bytes};
  const auto wait = [this](short event) { return wait_for_ever(socket_, event); };
  if (!send_bytes(socket_, &head, sizeof head, wait) || !send_bytes(socket_, from, bytes, wait)) ::_exit(1);
}

std::string reason_of_exception(const char* crash) {
  constexpr std::size_t max_length = 2000;
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return "it is damaged (reading it exceeds the limit of memory)";
  } catch (const std::exception& exception) {
    return message_of(exception).substr(0, max_length);
  } catch (...) {
    return crash;
  }
}

}  // namespace simplexseg
