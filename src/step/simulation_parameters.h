// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "forces/parameters.h"

namespace simplexseg {

/// Time integration, in the order of the choices of the parameter `solver` (docs/mathematics.md, section 3).
enum class Solver : int { Automatic, Verlet, Damped, Multigrid };

/// Parameters of the whole simulation, one for each entry of simulation_table().
struct SimulationParameters {
  float solver_choice;
  float timestep;
  float damping;
  float limit_timestep;
  float refresh_interval;
  float start_vertices;
  float final_vertices;
  float finest_edge;
  float steps_per_level;
  float rest_tolerance_voxels;
  float frame_budget_ms;

  /// True if no stability bound holds: with multigrid cycles, and with an unlimited timestep of the user.
  bool can_diverge() const {
    return solver() == Solver::Automatic || solver() == Solver::Multigrid ||
           (solver() == Solver::Verlet && limit_timestep < 0.5f);
  }
  Solver solver() const { return static_cast<Solver>(static_cast<int>(solver_choice + 0.5f)); }
};
std::span<const ParameterInfo> simulation_table();
SimulationParameters default_simulation_parameters();
/// Value of a parameter; `index`: its index in simulation_table().
float& value_of(SimulationParameters& parameters, int index);
float value_of(const SimulationParameters& parameters, int index);
/// False for parameters of the verlet solver while another solver is selected.
bool has_effect(const SimulationParameters& parameters, int index);

}  // namespace simplexseg
