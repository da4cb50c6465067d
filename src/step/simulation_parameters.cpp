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
      "Time integration: with the timestep and damping below (verlet), with values adapted to the mesh (damped), with "
      "an additional multigrid cycle (multigrid), or the faster of the last two (automatic).",
      ParameterKind::Choice, "automatic|verlet|damped|multigrid"}},
    {&SimulationParameters::timestep,
     {"timestep", 1.0f, 0.001f, 10, "",
      "Timestep of the verlet solver; forces act as accelerations of unit masses, "
      "unless area_in_mass is above 0."}},
    {&SimulationParameters::damping,
     {"damping", 0.9f, 0, 1, "", "Share of the velocity lost in one step of the verlet solver."}},
    {&SimulationParameters::limit_timestep,
     {"limit_timestep", 1, 0, 1, "",
      "Limits the timestep of the verlet solver to 90% of the stability bound of each mesh.", ParameterKind::Choice,
      "off|on"}},
    {&SimulationParameters::area_in_mass,
     {"area_in_mass", 0, 0, 1, "",
      "Share of the mass of a vertex that is proportional to its area, in the verlet solver; 0: unit masses."}},
    {&SimulationParameters::area_in_force,
     {"area_in_force", 0, 0, 1, "",
      "Share of the force on a vertex that is proportional to its area, in the verlet solver; 0: independent of it."}},
    {&SimulationParameters::refresh_interval,
     {"refresh_interval", 3, 1, 50, "steps", "Steps between two updates of image targets and attraction bindings.",
      ParameterKind::Integer}},
    {&SimulationParameters::start_vertices,
     {"start_vertices", 320, 20, 81920, "", "Vertices of a new mesh, rounded up to the next available sphere.",
      ParameterKind::Integer}},
    {&SimulationParameters::final_vertices,
     {"final_vertices", 5120, 20, 5242880, "", "Vertices of a mesh after its last refinement.",
      ParameterKind::Integer}},
    {&SimulationParameters::finest_edge,
     {"finest_edge", 1, 0, 20, "voxel", "A mesh with a shorter mean edge is not refined, and starts coarser."}},
    {&SimulationParameters::steps_per_level,
     {"steps_per_level", 60, 1, 100000, "steps", "Steps after which a mesh is refined, unless it settles earlier.",
      ParameterKind::Integer}},
    {&SimulationParameters::rest_tolerance_voxels,
     {"rest_tolerance", 0.002f, 0, 1, "voxel",
      "Mean motion in a step below which a mesh counts as settled; it increases after 1000 steps."}},
    {&SimulationParameters::frame_budget_ms,
     {"frame_budget", 8, 1, 200, "ms", "Minimum time for the simulation in each frame of the window."}},
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
         member != &SimulationParameters::limit_timestep && member != &SimulationParameters::area_in_mass &&
         member != &SimulationParameters::area_in_force;
}

}  // namespace simplexseg
