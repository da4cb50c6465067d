// SPDX-License-Identifier: Apache-2.0
#include "python/parameters.h"

#include "io/platform/files.h"
#include "io/scene/parameter_text.h"
#include "python/bindings.h"
#include "python/messages.h"
#include "step/simulation_parameters.h"

namespace simplexseg::python {
namespace {

std::string prefix_of(const ForceInfo* force) {
  return force ? std::string("forces.") + force->name + "." : std::string("simulation.");
}

/// Calls `visit(FoundParameter)` for all parameters, in the order of the tables.
template <class Visit>
void for_each_parameter(Visit visit) {
  const auto visit_table = [&](const ForceInfo* force, std::span<const ParameterInfo> table) {
    for (std::size_t p = 0; p < table.size(); ++p) visit(FoundParameter{force, static_cast<int>(p), &table[p]});
  };
  visit_table(nullptr, simulation_table());
  for (const ForceInfo& force : force_list()) visit_table(&force, force.parameters);
}

py::dict all_parameters() {
  py::dict result;
  for_each_parameter([&](const FoundParameter& found) {
    result[py::str(prefix_of(found.force) + found.info->name)] = py::cast(*found.info);
  });
  return result;
}

}  // namespace

FoundParameter find_named(const std::string& name) {
  FoundParameter result{nullptr, -1, nullptr};
  std::vector<std::string> names;
  for_each_parameter([&](const FoundParameter& found) {
    names.push_back(prefix_of(found.force) + found.info->name);
    if (names.back() == name) result = found;
  });
  if (!result.info)
    throw Error("parameters", "the name " + unknown_name(one_line(name), names), "see simplexseg.parameters()");
  return result;
}

float parameter_value(const std::string& name, const ParameterInfo& info, const py::object& value) {
  if (py::isinstance<py::str>(value)) return parameter_from_text(name, info, value.cast<std::string>());
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred()) throw py::error_already_set();
  return checked_parameter(name, info, number);
}

py::object python_value(const ParameterInfo& info, float value) {
  if (info.kind == ParameterKind::Choice) return py::str(parameter_to_text(info, value));
  if (info.kind == ParameterKind::Integer) return py::int_(static_cast<long>(value + 0.5f));
  return py::float_(short_double(value));
}

std::vector<std::string> settings_of(const py::object& mapping) {
  std::vector<std::string> lines;
  for (const auto& [name, value] : py::dict(mapping))
    lines.push_back(py::str(name).cast<std::string>() + "=" + py::str(value).cast<std::string>());
  return lines;
}

void bind_parameters(py::module_& module) {
  const auto value_at = [](float ParameterInfo::*member) {
    return [member](const ParameterInfo& info) { return python_value(info, info.*member); };
  };
  py::class_<ParameterInfo>(module, "Parameter", "Declaration of a parameter of the simulation or of a force.")
      .def_property_readonly("default", value_at(&ParameterInfo::default_value),
                             "Default value: a number, or the name of a choice.")
      .def_property_readonly("minimum", value_at(&ParameterInfo::minimum), "Smallest value, inclusive.")
      .def_property_readonly("maximum", value_at(&ParameterInfo::maximum), "Largest value, inclusive.")
      .def_readonly("unit", &ParameterInfo::unit, "Unit; \"\" if it has none.")
      .def_readonly("doc", &ParameterInfo::doc, "Meaning, in one sentence.")
      .def_property_readonly(
          "choices", [](const ParameterInfo& info) { return python_texts(choices_of(info)); },
          "Names of the choices; empty for a number.")
      .def("__repr__", [](const ParameterInfo& info) {
        return std::string("<simplexseg.Parameter ") + info.name + " = " + parameter_to_text(info, info.default_value) +
               ">";
      });
  module.def(
      "parameters", &all_parameters,
      "Returns all parameters by name: simulation.PARAMETER and forces.FORCE.PARAMETER. These are the names for\n"
      "set(), settings and `simplexseg-cli run --set`.");
}

}  // namespace simplexseg::python
