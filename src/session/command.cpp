// SPDX-License-Identifier: Apache-2.0
#include "session/command.h"

#include <algorithm>

#include "forces/parameters.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

// One overload per command: a command without a title does not compile.
const char* title(const AddMesh&) { return "add segmentation"; }
const char* title(const DeleteMesh&) { return "delete segmentation"; }
const char* title(const EditMesh&) { return "edit segmentation"; }
const char* title(const SetForceParameter&) { return "change force parameter"; }
const char* title(const SetSimulationParameter&) { return "change simulation parameter"; }
const char* title_of_paint(MarkKind kind) { return kind == MarkKind::Inside ? "paint" : "erase"; }
const char* title(const AddPoint& c) {
  if (c.edit != VoxelEdit::None) return info_of(c.edit).title;
  return c.brush.paints() ? title_of_paint(c.kind) : c.path_mm.empty() ? "add point" : "add stroke";
}
const char* title(const AddLasso& c) { return c.kind == MarkKind::Inside ? "add inside lasso" : "add outside lasso"; }
const char* title(const SetIntensityRange&) { return "change range of intensities"; }
const char* title(const SetModel& c) { return c.model ? "set model" : "remove model"; }
const char* title(const SetImages&) { return "choose images of segmentation"; }
const char* title(const EditVoxels& c) { return info_of(c.edit).title; }
const char* title(const MovePoint&) { return "move point"; }
const char* title(const DeletePoint&) { return "delete point"; }
const char* title(const SetStartModes&) { return "change start shape"; }
const char* title(const SetStart& c) { return c.start ? "start from network" : "start from seed"; }
const char* title(const ResetPose&) { return "reset segmentation"; }
const char* title(const RecordProfiles& c) { return c.from_model ? "use profiles of model" : "record profiles"; }
const char* title(const RefineMesh&) { return "refine segmentation"; }
const char* title(const DuplicateMesh&) { return "duplicate segmentation"; }
const char* title(const ReorderMesh&) { return "reorder segmentations"; }
const char* title(const SetParameters&) { return "change all parameters"; }
const char* title(const StartFieldUpdate&) { return "start field update"; }
const char* title(const CommitFieldUpdate&) { return "commit field update"; }
const char* title(const CommitPreliminaryField&) { return "commit preliminary field"; }
const char* title(const CancelFieldUpdate&) { return "cancel field update"; }
const char* title(const RequestFieldUpdate&) { return "request field update"; }
const char* title(const StartFieldComparison&) { return "start field comparison"; }
const char* title(const CommitFieldComparison&) { return "commit field comparison"; }
const char* title(const ChooseLabelPreset&) { return "choose label preset"; }
const char* title(const Undo&) { return "undo"; }
const char* title(const Redo&) { return "redo"; }
const char* title(const SetReference&) { return "set reference"; }
const char* title(const ResizePoint&) { return "resize point"; }
const char* title(const AddMeasurement&) { return "add measurement"; }
const char* title(const MoveMeasurement&) { return "move measurement"; }
const char* title(const RenameMeasurement&) { return "rename measurement"; }
const char* title(const DeleteMeasurement&) { return "delete measurement"; }
const char* title(const AddLayer&) { return "add layer"; }
const char* title(const EditLayer& c) {
  return c.name            ? "rename layer"
         : c.transform     ? "change transform of layer"
         : c.preprocessing ? "change filters of layer"
         : c.colour_map    ? "change colours of layer"
         : c.opacity       ? "change opacity of layer"
         : c.visible       ? (*c.visible ? "show layer" : "hide layer")
                           : "change window of layer";
}
const char* title(const FilterVolume& c) {
  return c.preprocessing.filters.empty() ? "remove filters of volume" : "filter volume";
}
const char* title(const RemoveLayer&) { return "remove layer"; }

/// Replaces underscores by blanks: "a_name" -> "a name".
std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string mesh_suffix(ItemId mesh, const Scene& scene) {
  if (mesh == 0) return scene.meshes.size() == 1 ? ": " + scene.meshes[0].name : ": all segmentations";
  const MeshItem* const item = scene.find_mesh(mesh);
  return item ? ": " + item->name : std::string();
}

const char* name_of(MarkKind kind) {
  return kind == MarkKind::Inside ? "inside" : kind == MarkKind::Outside ? "outside" : "boundary";
}

template <class C>
concept ForOneMesh = requires(const C& c) {
  c.mesh;
};

template <class C>
std::string description(const C& c, const Scene&) {
  return title(c);
}
std::string description(const ForOneMesh auto& c, const Scene& scene) { return title(c) + mesh_suffix(c.mesh, scene); }
std::string description(const AddMesh& c, const Scene&) {
  return c.name.empty() ? title(c) : std::string(title(c)) + ": " + c.name;
}
std::string description(const AddPoint& c, const Scene& scene) {
  if (c.brush.paints()) return title(c) + mesh_suffix(c.mesh, scene);
  return std::string("add ") + name_of(c.kind) + (c.path_mm.empty() ? " point" : " stroke") +
         mesh_suffix(c.mesh, scene);
}
std::string description_of_point(const char* verb, ItemId id, const Scene& scene) {
  const UserPoint* const point = scene.find_point(id);
  if (!point) return std::string(verb) + " point";
  if (point->edit != VoxelEdit::None)
    return std::string(verb) + " paint of '" + info_of(point->edit).title + "'" + mesh_suffix(point->mesh, scene);
  if (point->is_paint())
    return std::string(verb) + (point->kind == MarkKind::Inside ? " paint" : " eraser stroke") +
           mesh_suffix(point->mesh, scene);
  const char* const what = point->is_lasso() ? " lasso" : point->is_stroke() ? " stroke" : " point";
  return std::string(verb) + " " + name_of(point->kind) + what + mesh_suffix(point->mesh, scene);
}
std::string description(const MovePoint& c, const Scene& scene) { return description_of_point("move", c.point, scene); }
std::string description(const DeletePoint& c, const Scene& scene) {
  return description_of_point("delete", c.point, scene);
}
std::string description(const AddMeasurement& c, const Scene&) { return std::string("add ") + name_of(c.kind); }
template <class C>
concept ForOneMeasurement = requires(const C& c) {
  c.measurement;
};
std::string description(const ForOneMeasurement auto& c, const Scene& scene) {
  const Measurement* const item = scene.find_measurement(c.measurement);
  return item ? std::string(title(c)) + ": " + item->name : title(c);
}
std::string description(const AddLayer& c, const Scene&) { return std::string(title(c)) + ": " + c.item.name; }
template <class C>
concept ForOneLayer = requires(const C& c) {
  c.layer;
};
std::string description(const ForOneLayer auto& c, const Scene& scene) {
  const LayerItem* const item = scene.find_layer(c.layer);
  return item ? std::string(title(c)) + ": " + item->name : title(c);
}
std::string description(const EditMesh& c, const Scene& scene) {
  const char* what = c.name      ? "rename segmentation"
                     : c.colour  ? "change colour"
                     : c.visible ? (*c.visible ? "show segmentation" : "hide segmentation")
                     : c.label   ? "change label"
                     : c.locked  ? (*c.locked ? "lock segmentation" : "unlock segmentation")
                     : c.opacity ? "change opacity"
                     : c.code    ? "change code"
                                 : title(c);
  return what + mesh_suffix(c.mesh, scene);
}
std::string description(const ChooseLabelPreset& c, const Scene&) {
  return title(c) + (c.preset.empty() ? ": none" : ": " + c.preset);
}
std::string description(const SetForceParameter& c, const Scene& scene) {
  const ForceInfo& force = force_list()[static_cast<std::size_t>(c.force)];
  const std::string name = force.parameters[static_cast<std::size_t>(c.parameter)].name;
  return std::string(force.title) + ", " + spaced(name) + mesh_suffix(c.mesh, scene);
}
std::string description(const SetSimulationParameter& c, const Scene&) {
  return "simulation, " + spaced(simulation_table()[static_cast<std::size_t>(c.parameter)].name);
}

}  // namespace

std::string describe(const Command& command, const Scene& before) {
  return std::visit([&before](const auto& one) { return description(one, before); }, command);
}

const char* title_of(const Command& command) {
  return std::visit([](const auto& one) { return title(one); }, command);
}

}  // namespace simplexseg
