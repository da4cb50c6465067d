// SPDX-License-Identifier: Apache-2.0
// Parameters by the names that --set has: simulation.PARAMETER and forces.FORCE.PARAMETER.
#pragma once
#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "forces/parameters.h"

namespace simplexseg::python {

/// One parameter of the tables.
struct FoundParameter {
  const ForceInfo* force;  ///< null: of the simulation
  int index;               ///< in its table
  const ParameterInfo* info;
};
/// Throws Error naming the nearest where there is none of that name.
FoundParameter find_named(const std::string& name);

/// A number, or the name of a choice. Throws Error for what the parameter cannot be.
float parameter_value(const std::string& name, const ParameterInfo& info, const pybind11::object& value);
/// The name of the choice, or the number as short as scene files have it.
pybind11::object python_value(const ParameterInfo& info, float value);

/// "NAME=VALUE" of each, for set_by_path().
std::vector<std::string> settings_of(const pybind11::object& mapping);

}  // namespace simplexseg::python
