// SPDX-License-Identifier: Apache-2.0
#include "session/scene_editor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "core/number_text.h"
#include "field/box_prompt.h"
#include "field/lasso_prompt.h"
#include "forces/force_list.h"
#include "session/edited_voxels.h"
#include "session/free_attributes.h"
#include "session/lasso.h"
#include "session/mesh_lifecycle.h"
#include "session/mesh_marks.h"
#include "session/scene_checks.h"

namespace simplexseg {
namespace {

/// Prompts of the box of AddMesh.
BoxPrompt prompt_of(const std::vector<Eigen::Vector3d>& corners_mm, const Volume& volume) {
  BoxCorners corners;
  if (corners_mm.size() != corners.size()) throw Error("the box", "it does not have four corners", "give four");
  if (volume.empty()) throw Error("the box", "there is no volume", "open a volume first");
  std::copy(corners_mm.begin(), corners_mm.end(), corners.begin());
  return prompt_of_box(corners, volume.geometry());
}

}  // namespace

SceneChange SceneEditor::execute(const AddMesh& command) {
  MeshItem item;
  item.id = next_id_++;
  item.name = command.name;
  if (item.name.empty()) item.name = free_name(scene_);
  if (scene_.find_mesh(item.name))
    throw Error("segmentation '" + item.name + "'", "another one has that name", "choose another name");
  item.seed = command.seed;
  std::optional<BoxPrompt> box;
  if (!command.box_mm.empty()) {
    box = prompt_of(command.box_mm, volume_);
    item.seed = {box->seed.position_mm, box->seed.radius_mm};
  }
  std::optional<UserPoint> lasso;
  if (!command.contour_mm.empty()) {
    if (box) throw Error("segmentation '" + item.name + "'", "it starts from a box and a lasso", "give one of them");
    lasso = new_lasso(MarkKind::Inside, command.contour_mm, command.contour_normal, item.id, true);
    const Mark seed = seed_of_lasso(command.contour_mm, command.contour_normal, volume_.geometry());
    item.seed = {seed.position_mm, seed.radius_mm};
  }
  if (command.start && !command.start->mesh)
    throw Error("segmentation '" + item.name + "'", "its labels or mesh were not read", "read them first");
  item.start = command.start;
  check_model(item, command.model.get());
  item.model = command.model;
  check_seed(item.seed, item.name, volume_);
  item.colour = command.colour.value_or(free_colour(scene_));
  item.label = label_of_name(scene_, item.name, item.id);
  if (item.label == 0) item.label = free_label(scene_);
  check_code(command.code, item.name);
  item.code = command.code;
  const MeshItem* like = scene_.find_mesh(command.like);
  item.parameters = like ? like->parameters : scene_.forces;
  restart(item, scene_.simulation, volume_);
  scene_.meshes.push_back(std::move(item));
  const ItemId added = scene_.meshes.back().id;
  if (box) add_strokes(box->strokes, added);
  if (lasso) {
    lasso->id = next_id_++;
    scene_.points.push_back(std::move(*lasso));
  }
  return {EngineUpdate::Meshes, added};
}

void SceneEditor::remember_label(const MeshItem& item) {
  if (is_default_name(item.name)) return;
  std::map<std::string, int>& labels = scene_.labels.by_name;
  const bool taken = std::any_of(labels.begin(), labels.end(), [&](const auto& entry) {
    return entry.second == item.label && entry.first != item.name;
  });
  if (!taken) labels[item.name] = item.label;
}

void SceneEditor::add_strokes(const std::vector<PromptStroke>& strokes, ItemId mesh) {
  for (const PromptStroke& stroke : strokes) {
    UserPoint point{next_id_++, mesh, stroke.path_mm.front(), stroke.kind, stroke.radius_mm};
    for (std::size_t p = 1; p < stroke.path_mm.size(); ++p)
      point.path_mm.emplace_back(stroke.path_mm[p] - point.position_mm);
    point.continues = true;
    scene_.points.push_back(std::move(point));
  }
}

UserPoint SceneEditor::new_lasso(MarkKind kind, const std::vector<Eigen::Vector3d>& contour_mm,
                                 const Eigen::Vector3d& normal, ItemId mesh, bool starts) {
  if (volume_.empty()) throw Error("the lasso", "there is no volume", "open one first");
  if (contour_mm.empty()) throw Error("the lasso", "it has fewer than three vertices", "draw around the part");
  UserPoint lasso = lasso_of(mesh, kind, contour_mm, normal);
  lasso.continues = starts;  // applied in the same update as the seed
  update_lasso(lasso, volume_);
  return lasso;
}

SceneChange SceneEditor::execute(const DeleteMesh& command) {
  remember_label(item_of(command.mesh));
  std::erase_if(scene_.points, [&](const UserPoint& point) { return point.mesh == command.mesh; });
  std::erase_if(scene_.meshes, [&](const MeshItem& item) { return item.id == command.mesh; });
  return {EngineUpdate::Meshes};
}

SceneChange SceneEditor::execute(const EditMesh& command) {
  MeshItem& item = item_of(command.mesh);
  const bool renames = command.name && *command.name != item.name;
  if (renames && (command.name->empty() || scene_.find_mesh(*command.name)))
    throw Error("the name '" + *command.name + "'",
                command.name->empty() ? "it is empty" : "another segmentation has it", "choose another name");
  if (command.label && (*command.label < 1 || *command.label > 65535))
    throw Error("label " + std::to_string(*command.label), "labels have 16 bits and 0 is background",
                "choose 1 to 65535");
  if (command.opacity && !(*command.opacity > 0 && *command.opacity <= 1))
    throw Error("the opacity of segmentation '" + item.name + "'",
                general_text(*command.opacity, 6) + " is out of range", "give a value above 0 and up to 1");
  if (command.code) check_code(*command.code, item.name);
  const int label_of_new_name = renames ? label_of_name(scene_, *command.name, item.id) : 0;
  const int label = command.label ? *command.label : label_of_new_name > 0 ? label_of_new_name : item.label;
  if (renames && label != item.label) remember_label(item);
  item.name = command.name.value_or(item.name);
  item.colour = command.colour.value_or(item.colour);
  item.visible = command.visible.value_or(item.visible);
  item.label = label;
  item.code = command.code.value_or(item.code);
  item.opacity = command.opacity.value_or(item.opacity);
  if (command.locked.value_or(item.locked) == item.locked) return {EngineUpdate::Nothing};
  item.locked = *command.locked;
  item.previous = item.mesh.positions;  // zero velocity
  item.solver = {}, item.sleep = {};
  return {EngineUpdate::Meshes};
}

SceneChange SceneEditor::execute(const ChooseLabelPreset& command) {
  check_labels(command.by_name);
  set_labels(scene_, {command.preset, command.by_name});
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const SetForceParameter& command) {
  const auto force_index = static_cast<std::size_t>(command.force);
  SIMPLEXSEG_EXPECT(force_index < force_list().size());
  const ForceInfo& force = force_list()[force_index];
  if (command.parameter < 0 || command.parameter >= static_cast<int>(force.parameters.size()))
    throw Error(std::string("force ") + force.name, "it has no parameter of that index", "see its table");
  check_value(force.parameters[command.parameter], command.value, force.name);
  EngineUpdate update = EngineUpdate::Parameters;
  for (MeshItem* item : items_of(command.mesh)) {
    ForceParameters parameters = item->parameters;
    parameters.values[force_index][command.parameter] = command.value;
    if (set_parameters(*item, parameters, volume_)) update = EngineUpdate::Meshes;
  }
  return {update};
}

SceneChange SceneEditor::execute(const SetSimulationParameter& command) {
  if (command.parameter < 0 || command.parameter >= static_cast<int>(simulation_table().size()))
    throw Error("simulation", "it has no parameter of that index", "see its table");
  check_value(simulation_table()[command.parameter], command.value, "simulation");
  value_of(scene_.simulation, command.parameter) = command.value;
  return {EngineUpdate::Parameters};
}

SceneChange SceneEditor::execute(const AddPoint& command) {
  const MeshItem& item = item_of(command.mesh);
  refuse_locked(item);
  check_position(command.position_mm);
  check_mark(command.kind, command.position_mm, volume_);
  check_path(command.kind, command.path_mm);
  UserPoint point{next_id_++, command.mesh, command.position_mm, command.kind, command.radius_mm};
  point.path_mm = command.path_mm;
  point.brush = command.brush;
  point.edit = command.edit;
  point.local = command.local && !point.is_paint();
  if (point.is_paint()) {
    if (point.edit != VoxelEdit::None && !info_of(point.edit).uses_stroke)
      throw Error(info_of(point.edit).title, "it changes all voxels and needs no stroke", "use the command for it");
    check_paint(point);
    if (point.edit != VoxelEdit::None) {
      point.voxels = stroked_voxels(scene_, item, point, volume_);
      point.brush = {PaintBrush::Shape::Voxels};
      point.path_mm.clear();
    }
    scene_.points.push_back(std::move(point));
    return {EngineUpdate::Points, scene_.points.back().id};
  }
  if (!(point.radius_mm > 0)) point.radius_mm = stroke_radius_mm(item, point, volume_);
  check_stroke(point.path_mm, point.radius_mm);
  if (point.kind == MarkKind::Boundary)
    point.outward = command.outward.norm() > 0 && command.outward.allFinite()
                        ? Eigen::Vector3d(command.outward.normalized())
                        : outward_at(item, point.position_mm, volume_);
  scene_.points.push_back(point);
  return {EngineUpdate::Points, scene_.points.back().id};
}

SceneChange SceneEditor::execute(const MovePoint& command) {
  UserPoint& point = editable_point_of(command.point);
  if (point.voxels) throw Error("paint", "it is a set of voxels, which cannot move", "delete it and paint again");
  check_position(command.position_mm);
  if (point.is_lasso()) {
    UserPoint moved = point;
    moved.position_mm = command.position_mm;
    update_lasso(moved, volume_);
    point = std::move(moved);
    return {EngineUpdate::Points};
  }
  check_mark(point.kind, command.position_mm, volume_);
  point.position_mm = command.position_mm;
  return {EngineUpdate::Points};
}

SceneChange SceneEditor::execute(const ResizePoint& command) {
  UserPoint& point = editable_point_of(command.point);
  if (point.kind == MarkKind::Boundary)
    throw Error("boundary point", "it marks a place on the surface and has no radius",
                "change the range of the attraction force instead");
  if (point.is_lasso()) throw Error("the lasso", "it is a contour and has no radius", "delete it and draw another one");
  check_radius(command.radius_mm);
  UserPoint resized = point;
  resized.radius_mm = command.radius_mm;
  if (!point.is_paint())
    check_stroke(point.path_mm, command.radius_mm);
  else if (point.brush.has_radius())
    check_paint(resized);
  else
    throw Error("paint", "it is not the stroke of a brush and has no radius", "delete it and paint again");
  point = std::move(resized);
  return {EngineUpdate::Points};
}

SceneChange SceneEditor::execute(const AddLasso& command) {
  refuse_locked(item_of(command.mesh));
  UserPoint lasso = new_lasso(command.kind, command.contour_mm, command.normal, command.mesh, false);
  lasso.local = command.local;
  lasso.id = next_id_;
  // Earlier versions added each stroke as a point: logs of them count an id for each.
  next_id_ += static_cast<ItemId>(stroke_count(lasso));
  scene_.points.push_back(std::move(lasso));
  return {EngineUpdate::Points, scene_.points.back().id};
}

SceneChange SceneEditor::execute(const SetIntensityRange& command) {
  MeshItem& item = item_of(command.mesh);
  refuse_locked(item);
  check_range(item, command.range);
  item.intensity_range = command.range;
  item.cancelled = nullptr;
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const SetModel& command) {
  MeshItem& item = item_of(command.mesh);
  refuse_locked(item);
  check_model(item, command.model.get());
  item.model = command.model;
  item.start_modes.clear(), item.model_profiles = false;
  item.cancelled = nullptr;
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const SetStartModes& command) {
  MeshItem& item = item_of(command.mesh);
  refuse_locked(item);
  MeshItem changed = item;
  changed.start_modes = command.modes;
  changed.model_profiles = changed.model_profiles && !command.modes.empty();
  check_start_modes(changed);
  restart(changed, scene_.simulation, volume_);
  item = std::move(changed);
  return {EngineUpdate::Meshes};
}

SceneChange SceneEditor::execute(const EditVoxels& command) {
  const MeshItem& item = item_of(command.mesh);
  refuse_locked(item);
  if (volume_.empty()) throw Error(info_of(command.edit).title, "there is no volume", "open one first");
  const VolumeGeometry& grid = volume_.geometry();
  UserPoint point{next_id_++, command.mesh};
  point.kind = MarkKind::Inside;
  point.edit = command.edit;
  point.voxels = edited_voxels(scene_, item, command.edit, command.size, scene_.find_mesh(command.other), grid);
  point.brush = {PaintBrush::Shape::Voxels};
  point.position_mm = point.voxels->box.centre_mm();
  scene_.points.push_back(std::move(point));
  return {EngineUpdate::Points, scene_.points.back().id};
}

SceneChange SceneEditor::execute(const SetReference& command) {
  item_of(command.mesh).reference = command.reference;
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const DeletePoint& command) {
  editable_point_of(command.point);
  std::erase_if(scene_.points, [&](const UserPoint& point) { return point.id == command.point; });
  return {EngineUpdate::Points};
}

SceneChange SceneEditor::execute(const AddMeasurement& command) {
  check_measurement(command.kind, command.points_mm);
  const std::string name = command.name.empty() ? free_name(scene_, command.kind) : command.name;
  scene_.measurements.push_back({next_id_++, command.kind, command.points_mm, name});
  return {EngineUpdate::Nothing, scene_.measurements.back().id};
}

SceneChange SceneEditor::execute(const MoveMeasurement& command) {
  Measurement& measurement = measurement_of(command.measurement);
  check_measurement(measurement.kind, command.points_mm);
  measurement.points_mm = command.points_mm;
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const RenameMeasurement& command) {
  Measurement& measurement = measurement_of(command.measurement);
  if (command.name.empty()) throw Error("the name of a measurement", "it is empty", "choose another name");
  measurement.name = command.name;
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const DeleteMeasurement& command) {
  measurement_of(command.measurement);
  std::erase_if(scene_.measurements, [&](const Measurement& one) { return one.id == command.measurement; });
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const ResetPose& command) {
  for (MeshItem* item : movable_items_of(command.mesh)) {
    item->final_vertices = 0;
    restart(*item, scene_.simulation, volume_);
  }
  return {EngineUpdate::Meshes};
}

SceneChange SceneEditor::execute(const RecordProfiles& command) {
  for (MeshItem* item : items_of(command.mesh))
    command.from_model ? use_model_profiles(*item, volume_) : record_profiles(*item, volume_);
  return {EngineUpdate::Meshes};
}

SceneChange SceneEditor::execute(const RefineMesh& command) {
  for (MeshItem* item : movable_items_of(command.mesh)) {
    refine_item(*item);
    const int default_vertices = static_cast<int>(scene_.simulation.final_vertices + 0.5f);
    item->final_vertices = std::max({item->final_vertices, default_vertices, item->mesh.vertex_count()});
  }
  return {EngineUpdate::Meshes};
}

SceneChange SceneEditor::execute(const DuplicateMesh& command) {
  MeshItem copy = item_of(command.mesh);
  const std::string base = copy.name + " copy";
  const auto name_of_copy = [&](int number) { return number == 1 ? base : base + " " + std::to_string(number); };
  copy.name = name_of_copy(
      first_free(scene_, [&](const MeshItem& other, int number) { return other.name == name_of_copy(number); }));
  copy.id = next_id_++;
  copy.label = free_label(scene_);
  copy.colour = free_colour(scene_);
  std::vector<UserPoint> points;
  for (const UserPoint& point : scene_.points)
    if (point.mesh == command.mesh) points.push_back(point);
  for (UserPoint& point : points) point.id = next_id_++, point.mesh = copy.id;
  scene_.points.insert(scene_.points.end(), points.begin(), points.end());
  const ItemId id = copy.id;
  const auto place = std::find_if(scene_.meshes.begin(), scene_.meshes.end(),
                                  [&](const MeshItem& item) { return item.id == command.mesh; });
  scene_.meshes.insert(place + 1, std::move(copy));
  return {EngineUpdate::Meshes, id};
}

SceneChange SceneEditor::execute(const ReorderMesh& command) {
  const std::ptrdiff_t from = &item_of(command.mesh) - scene_.meshes.data();
  const auto last = static_cast<std::ptrdiff_t>(scene_.meshes.size()) - 1;
  if (command.place < 0 || command.place > last)
    throw Error("place " + std::to_string(command.place) + " of segmentation '" + scene_.meshes[from].name + "'",
                "the list has no such place", "give 0 to " + std::to_string(last));
  const auto begin = scene_.meshes.begin();
  if (command.place < from)
    std::rotate(begin + command.place, begin + from, begin + from + 1);
  else
    std::rotate(begin + from, begin + from + 1, begin + command.place + 1);
  return {EngineUpdate::Meshes};
}

SceneChange SceneEditor::execute(const SetParameters& command) {
  for (const ForceInfo& force : force_list())
    for (std::size_t p = 0; p < force.parameters.size(); ++p)
      check_value(force.parameters[p], command.forces.values[static_cast<int>(force.id)][p], force.name);
  if (command.simulation)
    for (std::size_t p = 0; p < simulation_table().size(); ++p)
      check_value(simulation_table()[p], value_of(*command.simulation, static_cast<int>(p)), "simulation");
  EngineUpdate update = EngineUpdate::Parameters;
  for (MeshItem* item : items_of(command.mesh))
    if (set_parameters(*item, command.forces, volume_)) update = EngineUpdate::Meshes;
  if (command.simulation) scene_.simulation = *command.simulation;
  return {update};
}

MeshItem& SceneEditor::item_of(ItemId mesh) {
  if (mesh == 0) throw Error("segmentation 0", "the command is for a single segmentation", "choose one of the scene");
  return *items_of(mesh).front();
}

std::vector<MeshItem*> SceneEditor::items_of(ItemId mesh) {
  std::vector<MeshItem*> items;
  for (MeshItem& item : scene_.meshes)
    if (mesh == 0 || item.id == mesh) items.push_back(&item);
  if (items.empty() && mesh != 0)
    throw Error("segmentation " + std::to_string(mesh), "the scene has none with that id", "choose one of the scene");
  return items;
}

std::vector<MeshItem*> SceneEditor::movable_items_of(ItemId mesh) {
  std::vector<MeshItem*> items = items_of(mesh);
  if (mesh != 0) refuse_locked(*items.front());
  std::erase_if(items, [](const MeshItem* item) { return item->locked; });
  return items;
}

UserPoint& SceneEditor::editable_point_of(ItemId point) {
  for (UserPoint& one : scene_.points) {
    if (one.id != point) continue;
    if (const MeshItem* item = scene_.find_mesh(one.mesh)) refuse_locked(*item);
    return one;
  }
  throw Error("point " + std::to_string(point), "there is no such point", "choose a point of the scene");
}

Measurement& SceneEditor::measurement_of(ItemId measurement) {
  for (Measurement& one : scene_.measurements)
    if (one.id == measurement) return one;
  throw Error("measurement " + std::to_string(measurement), "there is no such measurement", "choose one of the scene");
}

}  // namespace simplexseg
