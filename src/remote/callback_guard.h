// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>

namespace simplexseg {

/// Guard for callbacks of a library through which exceptions must not pass. Stores the first exception, which the
/// caller of the library rethrows.
struct CallbackGuard {
  std::exception_ptr thrown;

  /// Calls f() and returns true. Returns false if f() throws; after an exception, returns false without calling f().
  template <class F>
  bool guarded(F&& f) {
    if (thrown) return false;
    try {
      f();
      return true;
    } catch (...) {
      thrown = std::current_exception();
      return false;
    }
  }
};

}  // namespace simplexseg
