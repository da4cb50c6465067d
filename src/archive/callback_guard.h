// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>

namespace simplexseg {

/// Guard for callbacks that a C library calls, through which exceptions must not pass. Stores the exception for the
/// caller of the library to rethrow.
struct CallbackGuard {
  std::exception_ptr thrown;

  /// Calls f() and returns true. Returns false if it threw, or without a call if an earlier one threw.
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
