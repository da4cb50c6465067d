// SPDX-License-Identifier: Apache-2.0
// Defaults and stability bounds that docs/mathematics.md quotes, against the tables in the source.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "core/number_text.h"
#include "forces/parameters.h"
#include "io/scene/parameter_text.h"
#include "step/simulation_parameters.h"
#include "step/stability.h"

namespace simplexseg {
namespace {

double number(const std::string& text) { return parse_number(text).value(); }

std::string mathematics() {
  std::ifstream file(std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "docs/mathematics.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Quoted defaults of each section: "Defaults of `NAME`: `PARAMETER` VALUE, ...", up to the end of the sentence.
std::map<std::string, std::map<std::string, std::string>> quoted_defaults(const std::string& text) {
  std::map<std::string, std::map<std::string, std::string>> defaults;
  const std::regex sentence(R"(Defaults\s+of\s+`(\w+)`:((?:[^.]|\.\d)*)\.)"), item(R"(`(\w+)`\s+([-\w.]+))");
  for (std::sregex_iterator s(text.begin(), text.end(), sentence), end; s != end; ++s) {
    const std::string items = (*s)[2];
    for (std::sregex_iterator i(items.begin(), items.end(), item); i != end; ++i) defaults[(*s)[1]][(*i)[1]] = (*i)[2];
  }
  return defaults;
}

TEST(Mathematics, QuotesTheDefaultOfEveryParameterOfEveryForce) {
  auto quoted = quoted_defaults(mathematics());
  for (const ForceInfo& force : force_list()) {
    if (!quoted.contains(force.name)) {
      ADD_FAILURE() << "docs/mathematics.md quotes no defaults of " << force.name;
      continue;
    }
    auto& values = quoted[force.name];
    EXPECT_EQ(values.size(), force.parameters.size()) << force.name;
    for (const ParameterInfo& parameter : force.parameters)
      EXPECT_EQ(values[parameter.name], parameter_to_text(parameter, parameter.default_value))
          << force.name << "." << parameter.name;
  }
}

TEST(Mathematics, QuotesDefaultsOfTheSimulation) {
  const auto quoted = quoted_defaults(mathematics())["simulation"];
  EXPECT_GE(quoted.size(), 6u);
  for (const auto& [name, value] : quoted) {
    const int index = find_parameter(simulation_table(), name.c_str());
    ASSERT_GE(index, 0) << name;
    const ParameterInfo& parameter = simulation_table()[static_cast<std::size_t>(index)];
    EXPECT_EQ(value, parameter_to_text(parameter, parameter.default_value)) << name;
  }
}

/// Stability bound of one force at its defaults and a weight of 1, with a reference of positive metric parameters.
float bound_at_defaults(const ForceInfo& force) {
  ForceParameters parameters{};
  for (const ForceInfo& other : force_list())
    for (std::size_t k = 0; k < other.parameters.size(); ++k)
      parameters.values[static_cast<int>(other.id)][k] = k == 0 ? 0.0f : other.parameters[k].default_value;
  parameters.values[static_cast<int>(force.id)][0] = 1;
  const std::vector<Vec4> reference(1, Vec4{0.25f, 0.25f, 0.0f, 1.0f});
  return stiffness_bound(parameters, reference);
}

TEST(Mathematics, QuotesTheStabilityBoundOfEveryForce) {
  const std::string text = mathematics();
  const std::regex row(R"(\n\| `(\w+)` \|[^|]*(?:\\\|[^|]*)*\| ([\d.]+) \|)");
  std::map<std::string, float> quoted;
  for (std::sregex_iterator r(text.begin(), text.end(), row), end; r != end; ++r)
    if (find_force((*r)[1].str().c_str())) quoted[(*r)[1]] = static_cast<float>(number((*r)[2]));
  for (const ForceInfo& force : force_list()) {
    ASSERT_TRUE(quoted.contains(force.name)) << force.name;
    EXPECT_FLOAT_EQ(quoted[force.name], bound_at_defaults(force)) << force.name;
  }
}

TEST(Mathematics, TheExampleTimestepFollowsFromTheDefaultWeights) {
  const std::string text = mathematics();
  const std::regex example(
      R"(= ([\d.]+) \(smoothing, evidence, attraction\)\. With g = ([\d.]+) the\s+stable timestep is [^=]*= ([\d.]+), and the effective timestep is ([\d.]+)\.)");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(text, match, example));
  const SimulationParameters simulation = default_simulation_parameters();
  const float stiffness = stiffness_bound(default_force_parameters(), {});
  EXPECT_FLOAT_EQ(static_cast<float>(number(match[1])), stiffness);
  EXPECT_FLOAT_EQ(static_cast<float>(number(match[2])), simulation.damping);
  EXPECT_NEAR(number(match[3]), stable_timestep(stiffness, simulation.damping), 5e-4);
  EXPECT_NEAR(number(match[4]), effective_timestep(simulation, stiffness), 5e-4);
}

}  // namespace
}  // namespace simplexseg
