// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/pybind11.h>
#include <unistd.h>

namespace simplexseg::python {

/// Releases the GIL during its lifetime; the thread must hold the GIL before. Differs from pybind11's class at the end
/// of the interpreter: Python then unwinds a thread that requests the GIL, and an exception in a destructor aborts the
/// process. This class suspends the thread instead.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  ~WithoutGil() {
    try {
      PyEval_RestoreThread(state_);
    } catch (...) {
      for (;;) ::pause();
    }
  }
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

 private:
  PyThreadState* state_;
};

}  // namespace simplexseg::python
