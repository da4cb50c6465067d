// SPDX-License-Identifier: Apache-2.0
// One user action: unit of undo, line of the log, what a replay repeats.
#pragma once
#include <string>
#include <variant>

#include "session/scene.h"

namespace simplexseg {

/// Puts a sphere into the volume, or the mesh of `start`. The new mesh takes the default parameters of `like` (a mesh
/// id), or of the scene.
struct AddMesh {
  std::string name;  ///< empty: the first "mesh N" that is free
  Seed seed;
  std::optional<Colour> colour;  ///< none: the first of the palette that no mesh has
  ItemId like = 0;
  std::optional<MeshStart> start{};  ///< with its mesh; `seed` then lies within that
};
struct DeleteMesh {
  ItemId mesh;
};
/// Only the members that are set change.
struct EditMesh {
  ItemId mesh;
  std::optional<std::string> name;
  std::optional<Colour> colour;
  std::optional<bool> visible;
  std::optional<int> label;
  std::optional<bool> locked{};
  std::optional<float> opacity{};
};
/// What the mesh is compared with. Says nothing of its pose.
struct SetReference {
  ItemId mesh;
  std::optional<Reference> reference;  ///< none: nothing
  bool continues = false;              ///< one of several meshes that get theirs at once: undone together
};
/// mesh = 0: every mesh.
struct SetForceParameter {
  ItemId mesh;
  ForceId force;
  int parameter;  ///< index in the force's table
  float value;
  bool continues = false;  ///< part of the slider movement that the command before began: undone together with it
};
struct SetSimulationParameter {
  int parameter;  ///< index in simulation_table()
  float value;
  bool continues = false;  ///< as in SetForceParameter
};
/// All parameters of the forces of a mesh at once, and those of the simulation where they are given. mesh = 0: every
/// mesh.
struct SetParameters {
  ItemId mesh;
  ForceParameters forces;
  std::optional<SimulationParameters> simulation;
};
struct AddPoint {
  ItemId mesh;
  Eigen::Vector3d position_mm;
  MarkKind kind = MarkKind::Boundary;
  double radius_mm = 0;              ///< of the ball that it marks; 0: what suits the mesh's field
  Eigen::Vector3d outward{0, 0, 0};  ///< of a boundary point: the way out of the object; 0: as the surface nearby says
};
struct MovePoint {
  ItemId point;
  Eigen::Vector3d position_mm;
  bool continues = false;  ///< part of the drag that the command before began: undone together with it
};
/// Another ball that an inside or outside point marks.
struct ResizePoint {
  ItemId point;
  double radius_mm;
  bool continues = false;  ///< part of the turn of a wheel that the command before began: undone together with it
};
struct DeletePoint {
  ItemId point;
};
/// Back to the seed sphere, at the first level. mesh = 0: every mesh that is not locked.
struct ResetPose {
  ItemId mesh;
};
/// Takes the intensity profiles under the present pose as the reference of the intensity-profile force. mesh = 0: every
/// mesh.
struct RecordProfiles {
  ItemId mesh;
};
/// x4 refinement now. mesh = 0: every mesh that is not locked.
struct RefineMesh {
  ItemId mesh;
};
/// A copy of a mesh with its pose and points, under the first name, label and colour that are free.
struct DuplicateMesh {
  ItemId mesh;
};
/// Gives a mesh another place in the list, from 0 on; those behind make room.
struct PlaceMesh {
  ItemId mesh;
  int place;
};
/// Begins to learn the field of a mesh from its marks as they are now. Not for undo.
struct LearnField {
  ItemId mesh;
};
/// The field that was begun last draws its mesh from now on. Not for undo.
struct TakeField {};
struct Undo {};
struct Redo {};

using Command = std::variant<AddMesh, DeleteMesh, EditMesh, SetForceParameter, SetSimulationParameter, AddPoint,
                             MovePoint, DeletePoint, ResetPose, RecordProfiles, RefineMesh, DuplicateMesh, PlaceMesh,
                             SetParameters, LearnField, TakeField, Undo, Redo, SetReference, ResizePoint>;

/// For menus ("Undo move point"), in lower case.
const char* title_of(const Command& command);
/// For a list of what was done: "add inside point: kidney", "Smoothing, weight: all meshes". `before`: the scene that
/// the command was given on.
std::string describe(const Command& command, const Scene& before);

/// A line of the log: the command came after `steps` further steps of the simulation.
struct LogEntry {
  int steps;
  Command command;
};

}  // namespace simplexseg
