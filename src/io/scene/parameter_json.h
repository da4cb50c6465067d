// SPDX-License-Identifier: Apache-2.0
// Parameter sets as JSON objects, for scenes, presets and logs. Templates over the JSON type keep the JSON library out
// of this header.
#pragma once
#include "forces/parameters.h"
#include "io/scene/json_output.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

class JsonInput;

/// Sets the parameters that the object contains; all others keep their values. Throws Error for an unknown key or an
/// invalid value.
void read_forces(const JsonInput& input, ForceParameters& forces);
void read_simulation(const JsonInput& input, SimulationParameters& simulation);

/// JSON of the force parameters that differ from `defaults`, or of all force parameters if `defaults` is null.
template <class Json>
Json forces_json(const ForceParameters& forces, const ForceParameters* defaults) {
  Json all = Json::object();
  for (const ForceInfo& force : force_list()) {
    for (std::size_t p = 0; p < force.parameters.size(); ++p) {
      const float value = forces.values[static_cast<int>(force.id)][p];
      if (defaults && defaults->values[static_cast<int>(force.id)][p] == value) continue;
      add_parameter(all[force.name], force.parameters[p], value);
    }
  }
  return all;
}

/// JSON of all simulation parameters.
template <class Json>
Json simulation_json(const SimulationParameters& simulation) {
  Json all = Json::object();
  for (const ParameterInfo& info : simulation_table()) {
    add_parameter(all, info, value_of(simulation, find_parameter(simulation_table(), info.name)));
  }
  return all;
}

}  // namespace simplexseg
