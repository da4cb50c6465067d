// SPDX-License-Identifier: Apache-2.0
// Parameters are declared once, in the table of their force (in this folder) or of the simulation
// (step/simulation_parameters.cpp). Scene files, sliders, help, documentation and tests are generated from the tables.
#pragma once
#include <cstddef>
#include <span>

#include "forces/force_id.h"

namespace simplexseg {

enum class ParameterKind { Real, Integer, Choice };

/// Description of a user-visible parameter. All values are stored as float; Integer and Choice are rounded on use.
struct ParameterInfo {
  const char* name;  ///< name in scene files: snake_case
  float default_value;
  float minimum, maximum;  ///< inclusive
  const char* unit;        ///< "" when dimensionless
  const char* doc;         ///< one sentence, shown as tooltip
  ParameterKind kind = ParameterKind::Real;
  const char* choices = "";  ///< names of a Choice separated by '|', value 0 first
};

/// Origin of a force, which determines its stability bound in a step.
enum class ForceKind {
  Internal,  ///< shape of the mesh; the full stability bound at every vertex
  Image,     ///< volume; fades where points attract; bound scaled by the confidence in the target
  External,  ///< points placed by the user
};

/// Largest number of parameters of a force; the first one is always its weight.
inline constexpr int kMaxForceParameters = 12;

/// Activation register of one mesh: weight and parameters of every force, in the order of the tables. May change
/// between any two steps; trivially copyable to the device.
struct ForceParameters {
  float values[kForceCount][kMaxForceParameters];
  constexpr float weight(ForceId force) const { return values[static_cast<int>(force)][0]; }
  /// Value of a parameter of kind Integer or Choice; `index`: its index in the force's table.
  constexpr int integer(ForceId force, int index) const {
    return static_cast<int>(values[static_cast<int>(force)][index] + 0.5f);
  }
};

/// Recorded references of a mesh, with which some forces compare it.
struct RecordedReferences {
  int vertex_count = 0;            ///< vertices of the mesh
  bool shape = false;              ///< the mesh has a reference pose for shape memory
  std::size_t profile_values = 0;  ///< number of values in all reference profiles
  bool field = false;              ///< the mesh has a foreground probability field
};

/// Description of one force.
struct ForceInfo {
  ForceId id;
  ForceKind kind;
  const char* name;   ///< name in scene files: snake_case
  const char* title;  ///< name in panels
  const char* doc;
  const char* targets;  ///< name of the array of its targets; nullptr: a force without targets
  std::span<const ParameterInfo> parameters;
};
/// Descriptions of all forces, in the order of ForceId.
std::span<const ForceInfo> force_list();
/// Force of this name; nullptr if there is none.
const ForceInfo* find_force(const char* name);
/// Index of a parameter in a table; -1 if there is none of this name.
int find_parameter(std::span<const ParameterInfo> table, const char* name);
ForceParameters default_force_parameters();

}  // namespace simplexseg
