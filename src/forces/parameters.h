// SPDX-License-Identifier: Apache-2.0
// A parameter is declared once, in the table of its force (beside this file) or of the simulation
// (step/simulation_parameters.cpp), and reaches scene files, sliders, help, documentation and tests from there.
#pragma once
#include <cstddef>
#include <span>

#include "forces/force_id.h"

namespace simplexseg {

enum class ParameterKind { Real, Integer, Choice };

/// One user-visible parameter. All values are held as float; Integer and Choice are rounded where they are used.
struct ParameterInfo {
  const char* name;  ///< as in scene files: snake_case
  float default_value;
  float minimum, maximum;  ///< inclusive
  const char* unit;        ///< "" when dimensionless
  const char* doc;         ///< one sentence, as the tooltip shows it
  ParameterKind kind = ParameterKind::Real;
  const char* choices = "";  ///< of a Choice: names separated by '|', value 0 first
};

/// Where a force comes from, hence how the step counts it.
enum class ForceKind {
  Internal,  ///< the shape of the mesh itself: every vertex has the whole of its stability bound
  Image,  ///< the volume: it fades where points pull, and a vertex has the share of the bound that it trusts its target
  External,  ///< what the user placed
};

/// Every force's first parameter is its weight.
inline constexpr int kMaxForceParameters = 12;

/// The activation register of one mesh: weight and parameters of every force, in the order of the tables. Changeable
/// between any two steps; trivially copyable to the device.
struct ForceParameters {
  float values[kForceCount][kMaxForceParameters];
  constexpr float weight(ForceId force) const { return values[static_cast<int>(force)][0]; }
  /// The value of a parameter of kind Integer or Choice; `index`: in the force's table.
  constexpr int integer(ForceId force, int index) const {
    return static_cast<int>(values[static_cast<int>(force)][index] + 0.5f);
  }
};

/// What was recorded of a mesh, for forces that compare with it.
struct RecordedReferences {
  int vertex_count = 0;            ///< of the mesh
  bool shape = false;              ///< shape memory's reference was taken
  std::size_t profile_values = 0;  ///< of all reference profiles of the mesh
  bool field = false;              ///< the mesh has a field P(object)
};

/// What the list of forces says of one force.
struct ForceInfo {
  ForceId id;
  ForceKind kind;
  const char* name;   ///< as in scene files: snake_case
  const char* title;  ///< as panels show it
  const char* doc;
  const char* targets;  ///< the array of the targets that it finds at each refresh; nullptr: it finds none
  std::span<const ParameterInfo> parameters;
};
/// All forces, in the order of ForceId.
std::span<const ForceInfo> force_list();
/// nullptr when there is no such force.
const ForceInfo* find_force(const char* name);
/// Index into the table of `force`, -1 when there is none of that name.
int find_parameter(std::span<const ParameterInfo> table, const char* name);
ForceParameters default_force_parameters();

}  // namespace simplexseg
