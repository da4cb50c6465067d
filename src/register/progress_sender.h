// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <mutex>

#include "io/platform/packing.h"
#include "io/platform/worker_channel.h"
#include "io/registration/registration_requests.h"

namespace simplexseg::in_register {

/// Sends the state of the work to the program, at most 20 times a second. Safe for several threads.
class ProgressSender {
 public:
  explicit ProgressSender(ResponseWriter& response) : response_(response) {}
  void send(const RegistrationProgress& progress) {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + std::chrono::milliseconds(50);
    response_.text(FrameKind::Progress, packed(progress));
  }

 private:
  ResponseWriter& response_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace simplexseg::in_register
