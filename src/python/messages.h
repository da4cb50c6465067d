// SPDX-License-Identifier: Apache-2.0
// Conversion of errors and warnings of the library to those of Python.
#pragma once
#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "core/error.h"

namespace simplexseg::python {

/// simplexseg.SimulationError: a step failed with every timestep that was tried.
class SimulationError : public Error {
 public:
  using Error::Error;
};

/// Converts a text to a Python string. Replaces bytes that are not UTF-8, which file names may contain.
pybind11::str python_text(const std::string& text);
pybind11::list python_texts(const std::vector<std::string>& texts);

/// Issues each line as a simplexseg.DataWarning. Throws if the warning filters of the user turn it into an exception.
void warn(const std::vector<std::string>& lines);

/// Runs pending signal handlers. Throws KeyboardInterrupt, or any other exception that a handler raises. The calling
/// thread must hold the GIL.
void check_signals();

}  // namespace simplexseg::python
