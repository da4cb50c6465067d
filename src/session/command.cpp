// SPDX-License-Identifier: Apache-2.0
#include "session/command.h"

#include <algorithm>

#include "forces/parameters.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

// One overload for each command: a new one that has no title does not compile.
const char* title(const AddMesh&) { return "add mesh"; }
const char* title(const DeleteMesh&) { return "delete mesh"; }
const char* title(const EditMesh&) { return "edit mesh"; }
const char* title(const SetForceParameter&) { return "change force parameter"; }
const char* title(const SetSimulationParameter&) { return "change simulation parameter"; }
const char* title(const AddPoint&) { return "add point"; }
const char* title(const MovePoint&) { return "move point"; }
const char* title(const DeletePoint&) { return "delete point"; }
const char* title(const ResetPose&) { return "reset pose"; }
const char* title(const RecordProfiles&) { return "record profiles"; }
const char* title(const RefineMesh&) { return "refine mesh"; }
const char* title(const DuplicateMesh&) { return "duplicate mesh"; }
const char* title(const PlaceMesh&) { return "move mesh in list"; }
const char* title(const SetParameters&) { return "set all parameters"; }
const char* title(const LearnField&) { return "learn field"; }
const char* title(const TakeField&) { return "take field"; }
const char* title(const Undo&) { return "undo"; }
const char* title(const Redo&) { return "redo"; }
const char* title(const SetReference&) { return "set reference"; }
const char* title(const ResizePoint&) { return "resize point"; }

/// "a_name" -> "a name".
std::string words_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string of_mesh(ItemId mesh, const Scene& scene) {
  if (mesh == 0) return scene.meshes.size() == 1 ? ": " + scene.meshes[0].name : ": all meshes";
  const MeshItem* const item = scene.find_mesh(mesh);
  return item ? ": " + item->name : std::string();
}

const char* word_of(MarkKind kind) {
  return kind == MarkKind::Inside ? "inside" : kind == MarkKind::Outside ? "outside" : "boundary";
}

template <class C>
concept OfAMesh = requires(const C& c) {
  c.mesh;
};

template <class C>
std::string description(const C& c, const Scene&) {
  return title(c);
}
std::string description(const OfAMesh auto& c, const Scene& scene) { return title(c) + of_mesh(c.mesh, scene); }
std::string description(const AddMesh& c, const Scene&) {
  return c.name.empty() ? title(c) : std::string(title(c)) + ": " + c.name;
}
std::string description(const AddPoint& c, const Scene& scene) {
  return std::string("add ") + word_of(c.kind) + " point" + of_mesh(c.mesh, scene);
}
std::string description_of_point(const char* verb, ItemId id, const Scene& scene) {
  const UserPoint* const point = scene.find_point(id);
  if (!point) return std::string(verb) + " point";
  return std::string(verb) + " " + word_of(point->kind) + " point" + of_mesh(point->mesh, scene);
}
std::string description(const MovePoint& c, const Scene& scene) { return description_of_point("move", c.point, scene); }
std::string description(const DeletePoint& c, const Scene& scene) {
  return description_of_point("delete", c.point, scene);
}
std::string description(const EditMesh& c, const Scene& scene) {
  const char* what = c.name      ? "rename mesh"
                     : c.colour  ? "colour of mesh"
                     : c.visible ? (*c.visible ? "show mesh" : "hide mesh")
                     : c.label   ? "label of mesh"
                     : c.locked  ? (*c.locked ? "lock mesh" : "unlock mesh")
                     : c.opacity ? "opacity of mesh"
                                 : title(c);
  return what + of_mesh(c.mesh, scene);
}
std::string description(const SetForceParameter& c, const Scene& scene) {
  const ForceInfo& force = force_list()[static_cast<std::size_t>(c.force)];
  const std::string name = force.parameters[static_cast<std::size_t>(c.parameter)].name;
  return std::string(force.title) + ", " + words_of(name) + of_mesh(c.mesh, scene);
}
std::string description(const SetSimulationParameter& c, const Scene&) {
  return "simulation, " + words_of(simulation_table()[static_cast<std::size_t>(c.parameter)].name);
}

}  // namespace

std::string describe(const Command& command, const Scene& before) {
  return std::visit([&before](const auto& one) { return description(one, before); }, command);
}

const char* title_of(const Command& command) {
  return std::visit([](const auto& one) { return title(one); }, command);
}

}  // namespace simplexseg
