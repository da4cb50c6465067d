// SPDX-License-Identifier: Apache-2.0
#include "io/scene/set_by_path.h"

#include <span>
#include <vector>

#include "core/error.h"
#include "io/platform/files.h"
#include "io/scene/parameter_text.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

void set_by_path(Scene& scene, const std::string& assignment) {
  const std::string where = std::string("--set '").append(one_line(assignment)).append("'");
  const std::string forms =
      "write meshes.NAME.FORCE.PARAMETER=VALUE, forces.FORCE.PARAMETER=VALUE or simulation.PARAMETER=VALUE";
  const std::size_t equals = assignment.rfind('=');
  if (equals == std::string::npos) throw Error(where, "it has no '='", forms);
  const std::string value = assignment.substr(equals + 1);
  // The name of a mesh may contain '.', so the force and the parameter are the texts after the last two '.'.
  std::string path = assignment.substr(0, equals);
  const auto pop = [&path] {
    const std::size_t dot = path.rfind('.');
    std::string last = dot == std::string::npos ? path : path.substr(dot + 1);
    path = dot == std::string::npos ? "" : path.substr(0, dot);
    return last;
  };
  const std::string parameter = pop();
  const auto index_in = [&](std::span<const ParameterInfo> table) {
    const int index = find_parameter(table, parameter.c_str());
    if (index < 0) throw Error(where, "the parameter " + unknown_name(parameter, names_of(table)), forms);
    return index;
  };

  if (path == "simulation") {
    const int index = index_in(simulation_table());
    value_of(scene.simulation, index) = parameter_from_text(where, simulation_table()[index], value);
    return;
  }
  const std::string force_name = pop();
  const bool all = path == "forces";
  if (!all && path.rfind("meshes.", 0) != 0) throw Error(where, "the path is unknown", forms);
  const ForceInfo* const force = find_force(force_name.c_str());
  if (!force) throw Error(where, "the force " + unknown_name(force_name, names_of(force_list())), forms);
  const int index = index_in(force->parameters);
  const float number = parameter_from_text(where, force->parameters[index], value);
  const std::string name = all ? "" : path.substr(7);
  std::vector<std::string> names;
  bool found = all;
  for (MeshItem& item : scene.meshes) {
    names.push_back(item.name);
    if (!all && item.name != name) continue;
    item.parameters.values[static_cast<int>(force->id)][index] = number;
    found = true;
  }
  if (!found) throw Error(where, "the mesh " + unknown_name(name, names), forms);
  if (all) scene.forces.values[static_cast<int>(force->id)][index] = number;
}

}  // namespace simplexseg
