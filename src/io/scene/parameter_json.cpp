// SPDX-License-Identifier: Apache-2.0
#include "io/scene/parameter_json.h"

#include "io/scene/json_input.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {

void read_forces(const JsonInput& input, ForceParameters& forces) {
  input.expect_keys(names_of(force_list()));
  for (const ForceInfo& force : force_list()) {
    if (!input.has(force.name)) continue;
    const JsonInput table = input[force.name];
    table.expect_keys(names_of(force.parameters));
    for (std::size_t p = 0; p < force.parameters.size(); ++p) {
      const ParameterInfo& info = force.parameters[p];
      if (table.has(info.name)) forces.values[static_cast<int>(force.id)][p] = table[info.name].parameter(info);
    }
  }
}

void read_simulation(const JsonInput& input, SimulationParameters& simulation) {
  input.expect_keys(names_of(simulation_table()));
  for (const ParameterInfo& info : simulation_table()) {
    const int index = find_parameter(simulation_table(), info.name);
    if (input.has(info.name)) value_of(simulation, index) = input[info.name].parameter(info);
  }
}

}  // namespace simplexseg
