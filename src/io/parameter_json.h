// SPDX-License-Identifier: Apache-2.0
// Sets of parameters as JSON objects: what scenes, presets and logs have in common. Templates over the JSON library's
// type, so that this header does not include it.
#pragma once
#include "forces/parameters.h"
#include "io/json_output.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

class JsonInput;

/// Takes the parameters that the object has; the others stay. Throws Error for an unknown key or a bad value.
void read_forces(const JsonInput& input, ForceParameters& forces);
void read_simulation(const JsonInput& input, SimulationParameters& simulation);

/// Those that differ from `defaults`, or all.
template <class Json>
Json forces_json(const ForceParameters& forces, const ForceParameters* defaults) {
  Json all = Json::object();
  for (const ForceInfo& force : force_list()) {
    for (std::size_t p = 0; p < force.parameters.size(); ++p) {
      const float value = forces.values[static_cast<int>(force.id)][p];
      if (defaults && defaults->values[static_cast<int>(force.id)][p] == value) continue;
      put_parameter(all[force.name], force.parameters[p], value);
    }
  }
  return all;
}

template <class Json>
Json simulation_json(const SimulationParameters& simulation) {
  Json all = Json::object();
  for (const ParameterInfo& info : simulation_table()) {
    put_parameter(all, info, value_of(simulation, find_parameter(simulation_table(), info.name)));
  }
  return all;
}

}  // namespace simplexseg
