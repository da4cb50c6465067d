// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/pybind11.h>

#include <chrono>
#include <future>

#include "io/load_progress.h"
#include "python/gil.h"
#include "python/messages.h"

namespace simplexseg::python {

/// What `work`, a reader, gives. It runs in a thread of its own, which must touch no Python object, while this one lets
/// other Python threads run and listens for signals: Ctrl+C calls the reader off.
template <class Work>
auto interruptible(Work work) {
  LoadProgress progress;
  auto result = std::async(std::launch::async, [&] {
    const LoadProgress::Scope bound(progress);
    return work();
  });
  const auto is_ready = [&] {
    const WithoutGil released;
    return result.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready;
  };
  while (!is_ready()) {
    try {
      check_signals();
    } catch (...) {
      progress.call_off();
      const WithoutGil released;
      result.wait();
      throw;
    }
  }
  return result.get();
}

}  // namespace simplexseg::python
