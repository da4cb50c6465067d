// SPDX-License-Identifier: Apache-2.0
#include "step/simulation_parameters.h"

#include <array>
#include <iterator>

namespace simplexseg {
namespace {

constexpr struct {
  float SimulationParameters::*member;
  ParameterInfo info;
} kParameters[] = {
    {&SimulationParameters::solver_choice,
     {"solver", 0, 0, 3, "",
      "How steps are taken: with the timestep and damping below (verlet), with those that suit the mesh (damped), with "
      "a multigrid cycle as well (multigrid), or with what is faster of the last two (automatic).",
      ParameterKind::Choice, "automatic|verlet|damped|multigrid"}},
    {&SimulationParameters::timestep,
     {"timestep", 1.0f, 0.001f, 10, "", "Timestep of the solver verlet; forces are accelerations of unit masses."}},
    {&SimulationParameters::damping,
     {"damping", 0.9f, 0, 1, "", "Share of the velocity lost in one step of the solver verlet."}},
    {&SimulationParameters::limit_timestep,
     {"limit_timestep", 1, 0, 1, "",
      "Whether the timestep of the solver verlet is cut to 90% of the stability bound of each mesh.",
      ParameterKind::Choice, "off|on"}},
    {&SimulationParameters::refresh_interval,
     {"refresh_interval", 3, 1, 50, "steps", "How often image targets and attraction bindings are found anew.",
      ParameterKind::Integer}},
    {&SimulationParameters::start_vertices,
     {"start_vertices", 320, 20, 81920, "", "Vertices of a new mesh, rounded up to the next sphere.",
      ParameterKind::Integer}},
    {&SimulationParameters::final_vertices,
     {"final_vertices", 5120, 20, 5242880, "", "Vertices that a mesh is refined to, level by level.",
      ParameterKind::Integer}},
    {&SimulationParameters::finest_edge,
     {"finest_edge", 1, 0, 20, "voxel", "A mesh whose mean edge is shorter is not refined, and starts coarser."}},
    {&SimulationParameters::steps_per_level,
     {"steps_per_level", 60, 1, 100000, "steps",
      "After how many steps a mesh is refined, unless it is at rest earlier.", ParameterKind::Integer}},
    {&SimulationParameters::rest_tolerance_voxels,
     {"rest_tolerance", 0.002f, 0, 1, "voxel", "Mean motion in a step below which a mesh is at rest."}},
    {&SimulationParameters::frame_budget_ms,
     {"frame_budget", 8, 1, 200, "ms", "Time that a frame of the window gives the simulation at least."}},
};
static_assert(std::size(kParameters) * sizeof(float) == sizeof(SimulationParameters), "one entry for each member");

constexpr auto kTable = [] {
  std::array<ParameterInfo, std::size(kParameters)> table{};
  for (std::size_t k = 0; k < table.size(); ++k) table[k] = kParameters[k].info;
  return table;
}();

}  // namespace

std::span<const ParameterInfo> simulation_table() { return kTable; }

SimulationParameters default_simulation_parameters() {
  SimulationParameters p{};
  for (const auto& parameter : kParameters) p.*parameter.member = parameter.info.default_value;
  return p;
}

float& value_of(SimulationParameters& parameters, int index) { return parameters.*kParameters[index].member; }
float value_of(const SimulationParameters& parameters, int index) { return parameters.*kParameters[index].member; }

bool has_effect(const SimulationParameters& parameters, int index) {
  if (parameters.solver() == Solver::Verlet) return true;
  const auto member = kParameters[index].member;
  return member != &SimulationParameters::timestep && member != &SimulationParameters::damping &&
         member != &SimulationParameters::limit_timestep;
}

}  // namespace simplexseg
