// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>

namespace simplexseg {

/// What callbacks below a library's code, which exceptions must not pass, keep of one: whoever called the library
/// throws it again.
struct BelowC {
  std::exception_ptr thrown;

  /// False where this call threw, or one before it, after which nothing is called any more.
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
