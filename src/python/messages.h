// SPDX-License-Identifier: Apache-2.0
// How failures and warnings of the library become Python's.
#pragma once
#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "core/error.h"

namespace simplexseg::python {

/// Steps that could not be done, where no smaller timestep helped: simplexseg.SimulationError.
class SimulationError : public Error {
 public:
  using Error::Error;
};

/// The text as Python has it; bytes that are no UTF-8, as file names may hold, are replaced.
pybind11::str python_text(const std::string& text);
pybind11::list python_texts(const std::vector<std::string>& texts);

/// Issues each line as a simplexseg.DataWarning. Throws what the user's filters make of it.
void warn(const std::vector<std::string>& lines);

/// Throws KeyboardInterrupt, or what else a signal's handler raised, where one came. The GIL must be held.
void check_signals();

}  // namespace simplexseg::python
