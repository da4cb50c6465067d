// SPDX-License-Identifier: Apache-2.0
// User actions. Each is one unit of undo and one line of the log.
#pragma once
#include <string>
#include <variant>

#include "session/scene.h"

namespace simplexseg {

/// Adds a sphere, or the mesh of `start`. Copies the parameters of the mesh `like`; 0: the defaults of the scene.
struct AddMesh {
  std::string name;  ///< empty: the first unused "mesh N"
  Seed seed;
  std::optional<Colour> colour;  ///< none: the first unused colour of the palette
  ItemId like = 0;
  std::optional<MeshStart> start{};  ///< includes its mesh; `seed` then lies inside that mesh
};
struct DeleteMesh {
  ItemId mesh;
};
/// Changes the members that are set.
struct EditMesh {
  ItemId mesh;
  std::optional<std::string> name;
  std::optional<Colour> colour;
  std::optional<bool> visible;
  std::optional<int> label;
  std::optional<bool> locked{};
  std::optional<float> opacity{};
};
/// Sets the reference that reports compare the mesh with. Does not affect its pose.
struct SetReference {
  ItemId mesh;
  std::optional<Reference> reference;  ///< none: removes it
  bool continues = false;              ///< undone together with the SetReference before it
};
/// mesh = 0: every mesh.
struct SetForceParameter {
  ItemId mesh;
  ForceId force;
  int parameter;  ///< index in the force's table
  float value;
  bool continues = false;  ///< same slider movement as the command before: undone together with it
};
struct SetSimulationParameter {
  int parameter;  ///< index in simulation_table()
  float value;
  bool continues = false;  ///< see SetForceParameter
};
/// Sets all force parameters of a mesh (0: of every mesh) and, where given, those of the simulation.
struct SetParameters {
  ItemId mesh;
  ForceParameters forces;
  std::optional<SimulationParameters> simulation;
};
struct AddPoint {
  ItemId mesh;
  Eigen::Vector3d position_mm;
  MarkKind kind = MarkKind::Boundary;
  double radius_mm = 0;              ///< radius of the marked ball; 0: chosen by mark_radius_mm()
  Eigen::Vector3d outward{0, 0, 0};  ///< boundary point: direction out of the object; 0: chosen by outward_at()
};
struct MovePoint {
  ItemId point;
  Eigen::Vector3d position_mm;
  bool continues = false;  ///< same drag as the command before: undone together with it
};
/// Changes the radius of the ball that an inside or outside point marks.
struct ResizePoint {
  ItemId point;
  double radius_mm;
  bool continues = false;  ///< same scroll gesture as the command before: undone together with it
};
struct DeletePoint {
  ItemId point;
};
/// Resets a mesh to its seed sphere or labels, at the first level. mesh = 0: every mesh that is not locked.
struct ResetPose {
  ItemId mesh;
};
/// Records the intensity profiles at the current pose as the reference of the intensity-profile force. mesh = 0: every
/// mesh.
struct RecordProfiles {
  ItemId mesh;
};
/// Refines a mesh to four times as many vertices. mesh = 0: every mesh that is not locked.
struct RefineMesh {
  ItemId mesh;
};
/// Copies a mesh with its pose and points, under the first unused name, label and colour.
struct DuplicateMesh {
  ItemId mesh;
};
/// Moves a mesh to another position in the list.
struct ReorderMesh {
  ItemId mesh;
  int place;  ///< from 0
};
/// Starts to solve the field of a mesh with its current marks. Cannot be undone.
struct StartFieldUpdate {
  ItemId mesh;
};
/// Waits for the field that was started last and attaches it to its mesh. Cannot be undone.
struct CommitFieldUpdate {};
struct Undo {};
struct Redo {};

using Command = std::variant<AddMesh, DeleteMesh, EditMesh, SetForceParameter, SetSimulationParameter, AddPoint,
                             MovePoint, DeletePoint, ResetPose, RecordProfiles, RefineMesh, DuplicateMesh, ReorderMesh,
                             SetParameters, StartFieldUpdate, CommitFieldUpdate, Undo, Redo, SetReference, ResizePoint>;

/// Title for menus ("Undo move point"), in lower case.
const char* title_of(const Command& command);
/// Entry for the list of actions: "add inside point: kidney", "Smoothing, weight: all segmentations". `before`: the
/// scene before the command.
std::string describe(const Command& command, const Scene& before);

/// Line of the log: a command, `steps` steps of the simulation after the previous line.
struct LogEntry {
  int steps;
  Command command;
};

}  // namespace simplexseg
