// SPDX-License-Identifier: Apache-2.0
// Access to parameters by name, as in the option --set: simulation.PARAMETER and forces.FORCE.PARAMETER.
#pragma once
#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "forces/parameters.h"

namespace simplexseg::python {

/// Parameter and its place in the table of the simulation or of a force.
struct FoundParameter {
  const ForceInfo* force;  ///< null for a parameter of the simulation
  int index;               ///< index in its table
  const ParameterInfo* info;
};
/// Finds a parameter by name. Throws Error, with the most similar name, if there is none.
FoundParameter find_named(const std::string& name);

/// Converts a number or the name of a choice to the value of a parameter. Throws Error for an invalid value.
float parameter_value(const std::string& name, const ParameterInfo& info, const pybind11::object& value);
/// Converts a value to Python: the name of the choice, or the number, as short as in scene files (0.1, not
/// 0.10000000149).
pybind11::object python_value(const ParameterInfo& info, float value);

/// Converts a mapping (dict) to strings "NAME=VALUE" for set_by_path().
std::vector<std::string> settings_of(const pybind11::object& mapping);

}  // namespace simplexseg::python
