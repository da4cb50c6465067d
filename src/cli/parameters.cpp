// SPDX-License-Identifier: Apache-2.0
#include "forces/parameters.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "cli/commands.h"
#include "cli/table.h"
#include "io/json_output.h"
#include "io/parameter_text.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

struct Options {
  bool json = false, markdown = false;
};

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string range_of(const ParameterInfo& info) {
  if (info.kind == ParameterKind::Choice) return joined(choices_of(info));
  return number_to_text(info.minimum) + " to " + number_to_text(info.maximum);
}

nlohmann::ordered_json table_json(std::span<const ParameterInfo> table) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const ParameterInfo& info : table) {
    nlohmann::ordered_json values;  // default, minimum and maximum as a scene file writes them
    put_parameter(values, info, info.default_value);
    nlohmann::ordered_json entry = {{"name", info.name}, {"default", values[info.name]}};
    if (info.kind == ParameterKind::Choice) {
      entry["choices"] = choices_of(info);
    } else {
      put_parameter(values, info, info.minimum);
      entry["minimum"] = values[info.name];
      put_parameter(values, info, info.maximum);
      entry["maximum"] = values[info.name];
    }
    entry["unit"] = info.unit;
    entry["doc"] = info.doc;
    list.push_back(std::move(entry));
  }
  return list;
}

void print_json(std::ostream& out) {
  nlohmann::ordered_json json = {{"simulation", table_json(simulation_table())},
                                 {"forces", nlohmann::ordered_json::array()}};
  for (const ForceInfo& force : force_list()) {
    json["forces"].push_back({{"name", force.name},
                              {"title", force.title},
                              {"doc", force.doc},
                              {"parameters", table_json(force.parameters)}});
  }
  out << json.dump(2) << "\n";
}

/// A text that holds no column mark.
std::string cell(const std::string& text) {
  std::string escaped;
  for (char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

void print_markdown_table(std::ostream& out, std::span<const ParameterInfo> table) {
  out << "| parameter | default | range | unit | meaning |\n|---|---|---|---|---|\n";
  for (const ParameterInfo& info : table) {
    out << "| `" << info.name << "` | " << parameter_to_text(info, info.default_value) << " | " << range_of(info)
        << " | " << info.unit << " | " << cell(info.doc) << " |\n";
  }
}

void print_markdown(std::ostream& out) {
  out << "# Parameters\n\nWritten by `simplexseg-cli parameters --markdown` out of the tables in the source; do not "
         "edit.\n\n"
         "## Simulation\n\nIn a scene file under `simulation`; on the command line `--set "
         "simulation.PARAMETER=VALUE`.\n\n";
  print_markdown_table(out, simulation_table());
  out << "\n## Forces\n\nIn a scene file under `forces`, for every mesh or for one; on the command line\n"
         "`--set forces.FORCE.PARAMETER=VALUE` or `--set meshes.NAME.FORCE.PARAMETER=VALUE`.\n";
  for (const ForceInfo& force : force_list()) {
    out << "\n### `" << force.name << "`: " << force.title << "\n\n" << force.doc << "\n\n";
    print_markdown_table(out, force.parameters);
  }
}

void print_text_table(std::ostream& out, std::span<const ParameterInfo> table) {
  std::vector<std::vector<std::string>> rows{{"  parameter", "default", "range", "unit", "meaning"}};
  for (const ParameterInfo& info : table) {
    rows.push_back({std::string("  ") + info.name, parameter_to_text(info, info.default_value), range_of(info),
                    info.unit, info.doc});
  }
  print_table(out, rows, rows[0].size());
}

void parameters(const Options& options, const Console& console) {
  if (options.json) return print_json(console.out);
  if (options.markdown) return print_markdown(console.out);
  console.out << "simulation\n";
  print_text_table(console.out, simulation_table());
  for (const ForceInfo& force : force_list()) {
    console.out << "\n" << force.name << ": " << force.doc << "\n";
    print_text_table(console.out, force.parameters);
  }
}

}  // namespace

void add_parameters(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("parameters", "All parameters of the simulation and the forces");
  const auto options = std::make_shared<Options>();
  const Option json = sub.add_flag("--json", options->json, "Print JSON");
  sub.add_flag("--markdown", options->markdown, "Print docs/parameters.md").excludes(json);
  sub.callback([options, &action] { action = [options](const Console& console) { parameters(*options, console); }; });
}

}  // namespace simplexseg
