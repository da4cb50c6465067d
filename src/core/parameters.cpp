// SPDX-License-Identifier: Apache-2.0
#include "core/parameters.h"

#include <cstring>
#include <utility>

#include "core/force_list.h"

namespace simplexseg {
namespace {

template <std::size_t... I>
constexpr auto make_force_list(std::index_sequence<I...>) {
  static_assert(((static_cast<std::size_t>(std::tuple_element_t<I, Forces>::id) == I) && ...), "order of ForceId");
  static_assert(((std::tuple_element_t<I, Forces>::parameter_count <= kMaxForceParameters) && ...));
  static_assert(((std::size(std::tuple_element_t<I, Forces>::parameters) == std::tuple_element_t<I, Forces>::parameter_count) && ...));
  return std::array<ForceInfo, sizeof...(I)>{
      ForceInfo{std::tuple_element_t<I, Forces>::id, std::tuple_element_t<I, Forces>::name,
                std::tuple_element_t<I, Forces>::title, std::tuple_element_t<I, Forces>::doc,
                std::tuple_element_t<I, Forces>::parameters}...};
}
constexpr auto kForceList = make_force_list(std::make_index_sequence<kForceCount>{});

constexpr ParameterInfo kSimulationTable[] = {
    {"solver", 0, 0, 3, "", "How steps are taken: with the timestep and damping below (verlet), with those that suit the mesh (damped), with a multigrid cycle as well (multigrid), or with what is faster of the last two (automatic).", ParameterKind::Choice, "automatic|verlet|damped|multigrid"},
    {"timestep", 1.0f, 0.001f, 10, "", "Timestep of the solver verlet; forces are accelerations of unit masses."},
    {"damping", 0.9f, 0, 1, "", "Share of the velocity lost in one step of the solver verlet."},
    {"limit_timestep", 1, 0, 1, "", "Whether the timestep of the solver verlet is cut to 90% of the stability bound of each mesh.", ParameterKind::Choice, "off|on"},
    {"refresh_interval", 3, 1, 50, "steps", "How often image targets and attraction bindings are found anew.", ParameterKind::Integer},
    {"start_vertices", 320, 20, 81920, "", "Vertices of a new mesh, rounded up to the next sphere.", ParameterKind::Integer},
    {"final_vertices", 5120, 20, 5242880, "", "Vertices that a mesh is refined to, level by level.", ParameterKind::Integer},
    {"finest_edge", 1, 0, 20, "voxel", "A mesh whose mean edge is shorter is not refined, and starts coarser."},
    {"steps_per_level", 60, 1, 100000, "steps", "After how many steps a mesh is refined, unless it is at rest earlier.", ParameterKind::Integer},
    {"rest_tolerance", 0.002f, 0, 1, "voxel", "Mean motion in a step below which a mesh is at rest."},
    {"frame_budget", 8, 1, 200, "ms", "Time that a frame of the window gives the simulation."},
};
static_assert(std::size(kSimulationTable) * sizeof(float) == sizeof(SimulationParameters));

}  // namespace

std::span<const ForceInfo> force_list() { return kForceList; }

const ForceInfo* find_force(const char* name) {
  for (const ForceInfo& force : kForceList)
    if (std::strcmp(force.name, name) == 0) return &force;
  return nullptr;
}

int find_parameter(std::span<const ParameterInfo> table, const char* name) {
  for (std::size_t k = 0; k < table.size(); ++k)
    if (std::strcmp(table[k].name, name) == 0) return static_cast<int>(k);
  return -1;
}

ForceParameters default_force_parameters() {
  ForceParameters p{};
  for (const ForceInfo& force : kForceList)
    for (std::size_t k = 0; k < force.parameters.size(); ++k)
      p.values[static_cast<int>(force.id)][k] = force.parameters[k].default_value;
  return p;
}

std::span<const ParameterInfo> simulation_table() { return kSimulationTable; }

SimulationParameters default_simulation_parameters() {
  SimulationParameters p{};
  for (std::size_t k = 0; k < std::size(kSimulationTable); ++k) value_of(p, static_cast<int>(k)) = kSimulationTable[k].default_value;
  return p;
}

// The struct's members lie in the order of the table; asserted above by size and in the tests by name.
float& value_of(SimulationParameters& parameters, int index) { return *(&parameters.solver_choice + index); }
float value_of(const SimulationParameters& parameters, int index) { return *(&parameters.solver_choice + index); }

bool has_effect(const SimulationParameters& parameters, int index) {
  if (parameters.solver() == Solver::Verlet) return true;
  const float* value = &parameters.solver_choice + index;
  return value != &parameters.timestep && value != &parameters.damping && value != &parameters.limit_timestep;
}

}  // namespace simplexseg
