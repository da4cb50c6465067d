// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/pybind11.h>
#include <unistd.h>

namespace simplexseg::python {

/// While one lives, this thread has let go of the GIL, which it must have held. As pybind11's own, but for the end of
/// the interpreter: that ends a thread which asks for the GIL by unwinding it, which no destructor lets pass, so that
/// the process would be aborted. Here the thread stops where it is.
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
