// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "forces/parameters.h"

namespace simplexseg {

/// Time integration, in the order of the choices of the parameter `solver` (docs/mathematics.md, section 3).
enum class Solver : int { Automatic, Verlet, Damped, Multigrid };

/// Parameters common to all meshes, one for each entry of simulation_table(), which lists their units and ranges.
struct SimulationParameters {
  float solver_choice;
  float timestep;
  float damping;
  float limit_timestep;
  float area_in_mass;
  float area_in_force;
  float refresh_interval;
  float start_vertices;
  float final_vertices;
  float finest_edge;
  float steps_per_level;
  float rest_tolerance_voxels;
  float frame_budget_ms;

  /// True if steps may be unstable: solver automatic or multigrid, or solver verlet with limit_timestep off.
  bool can_diverge() const {
    return solver() == Solver::Automatic || solver() == Solver::Multigrid ||
           (solver() == Solver::Verlet && limit_timestep < 0.5f);
  }
  /// True if steps use the areas of the vertices and their masses (docs/mathematics.md, section 3).
  bool uses_areas() const { return solver() == Solver::Verlet && (area_in_mass > 0 || area_in_force > 0); }
  Solver solver() const { return static_cast<Solver>(static_cast<int>(solver_choice + 0.5f)); }
};
std::span<const ParameterInfo> simulation_table();
SimulationParameters default_simulation_parameters();
/// Value of a parameter; `index`: its index in simulation_table().
float& value_of(SimulationParameters& parameters, int index);
float value_of(const SimulationParameters& parameters, int index);
/// False for parameters that only the verlet solver uses while another solver is selected. `index`: as in value_of().
bool has_effect(const SimulationParameters& parameters, int index);

}  // namespace simplexseg
