// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/pybind11.h>

#include <chrono>
#include <future>

#include "io/platform/load_progress.h"
#include "python/gil.h"
#include "python/messages.h"

namespace simplexseg::python {

/// Runs the reader `work` in a separate thread and returns its result. `work` must not use Python objects. The calling
/// thread releases the GIL and checks for signals every 50 ms: Ctrl+C cancels the reader.
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
      progress.cancel();
      const WithoutGil released;
      result.wait();
      throw;
    }
  }
  return result.get();
}

}  // namespace simplexseg::python
