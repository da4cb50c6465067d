// SPDX-License-Identifier: Apache-2.0
// Parameters are declared once, in the table of their force (in this folder) or of the simulation
// (step/simulation_parameters.cpp). Scene files, sliders, help, documentation and tests are generated from the tables.
#pragma once
#include <cstddef>
#include <span>

#include "forces/force_id.h"

namespace simplexseg {

enum class ParameterKind { Real, Integer, Choice };

/// Description of a user-visible parameter. All values are stored as float; those of kind Integer and Choice are
/// rounded when used.
struct ParameterInfo {
  const char* name;  ///< name in scene files, in snake_case
  float default_value;
  float minimum, maximum;  ///< allowed range, inclusive
  const char* unit;        ///< unit of the value; "" when dimensionless
  const char* doc;         ///< description in one sentence, shown as tooltip
  ParameterKind kind = ParameterKind::Real;
  const char* choices = "";  ///< names of the values of a Choice, separated by '|', value 0 first
};

/// Origin of a force, which determines its share in the stability bound of a vertex.
enum class ForceKind {
  Internal,  ///< shape of the mesh; has its full stability bound at every vertex
  Image,     ///< volume; fades where points attract; its bound at a vertex is the confidence in the target
  External,  ///< points placed by the user
};

/// Largest number of parameters of a force. The first parameter is always the weight.
inline constexpr int kMaxForceParameters = 12;

/// Activation register of one mesh: weight and parameters of every force, in the order of the tables. Its values may
/// change between any two steps. Trivially copyable, for the upload to a device.
struct ForceParameters {
  float values[kForceCount][kMaxForceParameters];
  constexpr float weight(ForceId force) const { return values[static_cast<int>(force)][0]; }
  /// Value of a parameter of kind Integer or Choice; `index`: its index in the force's table.
  constexpr int integer(ForceId force, int index) const {
    return static_cast<int>(values[static_cast<int>(force)][index] + 0.5f);
  }
};

/// Summary of the recorded references of a mesh. Some forces require a reference, with which they compare the mesh.
struct RecordedReferences {
  int vertex_count = 0;            ///< number of vertices of the mesh
  bool shape = false;              ///< true if the mesh has a reference pose for shape memory
  std::size_t profile_values = 0;  ///< number of values in all reference profiles
  bool field = false;              ///< true if the mesh has a foreground probability field
};

/// Description of one force.
struct ForceInfo {
  ForceId id;
  ForceKind kind;
  const char* name;   ///< name in scene files, in snake_case
  const char* title;  ///< name in panels
  const char* doc;
  const char* targets;  ///< name of the array of targets; nullptr for a force without targets
  std::span<const ParameterInfo> parameters;
};
/// Descriptions of all forces, in the order of ForceId.
std::span<const ForceInfo> force_list();
/// Description of the force of this name; nullptr if there is none.
const ForceInfo* find_force(const char* name);
/// Index of the parameter of this name in a table; -1 if there is none.
int find_parameter(std::span<const ParameterInfo> table, const char* name);
ForceParameters default_force_parameters();

}  // namespace simplexseg
