// SPDX-License-Identifier: Apache-2.0
#include "io/scene/log_io.h"

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "core/error.h"
#include "io/platform/atomic_file.h"
#include "io/scene/code_text.h"
#include "io/scene/colour_text.h"
#include "io/scene/json_input.h"
#include "io/scene/json_output.h"
#include "io/scene/label_numbers.h"
#include "io/scene/layer_text.h"
#include "io/scene/mesh_model.h"
#include "io/scene/mesh_start.h"
#include "io/scene/parameter_json.h"
#include "io/scene/parameter_text.h"
#include "io/scene/point_text.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kMaxInt = std::numeric_limits<int>::max();

// For each command, keys_json() converts it to a JSON object, and read_keys() reads it from a JSON object, which also
// has the key "command" and may have the key "after_steps".

Json colour_json(const Colour& c) { return Json::array({c.red, c.green, c.blue}); }

void expect_keys(const JsonInput& input, std::vector<std::string> known) {
  known.insert(known.end(), {"after_steps", "command"});
  input.expect_keys(known);
}

ItemId read_id(const JsonInput& input) { return static_cast<ItemId>(input.integer_between(0, kMaxInt)); }

const ForceInfo& info_of(ForceId force) { return force_list()[static_cast<std::size_t>(force)]; }

Json keys_json(const AddMesh& c) {
  Json json = {{"name", c.name}, {"centre_mm", vector_json<Json>(c.seed.centre_mm)}, {"radius_mm", c.seed.radius_mm}};
  if (c.colour) json["colour"] = colour_json(*c.colour);
  if (c.like) json["like"] = c.like;
  if (c.model) json["model"] = mesh_model_json<Json>(*c.model, c.model->path);
  if (c.start) json["start"] = start_json<Json>(*c.start, c.start->path);
  if (!c.box_mm.empty()) json["box_mm"] = path_json<Json>(c.box_mm);
  if (!c.contour_mm.empty())
    json["contour_mm"] = path_json<Json>(c.contour_mm), json["contour_normal"] = vector_json<Json>(c.contour_normal);
  if (!c.code.empty()) json["code"] = code_json<Json>(c.code);
  return json;
}
void read_keys(const JsonInput& in, AddMesh& c) {
  expect_keys(in, {"name", "centre_mm", "radius_mm", "colour", "like", "start", "box_mm", "code", "contour_mm",
                   "contour_normal", "model"});
  if (in.has("name")) c.name = in["name"].text_or_empty();
  c.seed = {in["centre_mm"].vector3(), read_radius(in["radius_mm"])};
  if (in.has("colour")) c.colour = colour_from_json(in["colour"]);
  if (in.has("like")) c.like = read_id(in["like"]);
  if (in.has("start")) c.start = mesh_start_from_json(in["start"]);
  if (in.has("model")) c.model = mesh_model_from_json(in["model"], {});
  if (in.has("box_mm")) c.box_mm = read_path(in["box_mm"]);
  if (in.has("contour_normal") && !(in.has("contour_mm") && in["contour_mm"].size() > 0))
    in["contour_normal"].fail("there is no contour", "give the vertices of the lasso, or leave it out");
  if (in.has("contour_mm"))
    c.contour_mm = read_path(in["contour_mm"]), c.contour_normal = in["contour_normal"].vector3();
  if (in.has("code")) c.code = read_code(in["code"]);
}

Json keys_json(const EditMesh& c) {
  Json json = {{"mesh", c.mesh}};
  if (c.name) json["name"] = *c.name;
  if (c.colour) json["colour"] = colour_json(*c.colour);
  if (c.visible) json["visible"] = *c.visible;
  if (c.label) json["label"] = *c.label;
  if (c.locked) json["locked"] = *c.locked;
  if (c.opacity) json["opacity"] = *c.opacity;
  if (c.code) json["code"] = code_json<Json>(*c.code);
  return json;
}
void read_keys(const JsonInput& in, EditMesh& c) {
  expect_keys(in, {"mesh", "name", "colour", "visible", "label", "locked", "opacity", "code"});
  c.mesh = read_id(in["mesh"]);
  if (in.has("name")) c.name = in["name"].text_or_empty();
  if (in.has("colour")) c.colour = colour_from_json(in["colour"]);
  if (in.has("visible")) c.visible = in["visible"].boolean();
  if (in.has("label")) c.label = in["label"].integer_between(std::numeric_limits<int>::min(), kMaxInt);
  if (in.has("locked")) c.locked = in["locked"].boolean();
  if (in.has("opacity")) c.opacity = static_cast<float>(in["opacity"].number());
  if (in.has("code")) c.code = read_code(in["code"]);
}

Json keys_json(const ChooseLabelPreset& c) { return labels_json<Json>({c.preset, c.by_name}); }
void read_keys(const JsonInput& in, ChooseLabelPreset& c) {
  expect_keys(in, {"preset", "by_name"});
  LabelNumbers labels = read_labels(in);
  c = {std::move(labels.preset), std::move(labels.by_name)};
}

/// Reads the keys "parameter" and "value" for a parameter in `table`.
void read_value(const JsonInput& in, std::span<const ParameterInfo> table, int& parameter, float& value) {
  const std::string name = in["parameter"].text();
  parameter = find_parameter(table, name.c_str());
  if (parameter < 0) in["parameter"].fail("the parameter " + unknown_name(name, names_of(table)), "correct it");
  value = in["value"].parameter(table[static_cast<std::size_t>(parameter)]);
}
Json value_json(const ParameterInfo& info, float value) {
  Json object;
  add_parameter(object, info, value);
  return object[info.name];
}

Json keys_json(const SetForceParameter& c) {
  const ForceInfo& force = info_of(c.force);
  const ParameterInfo& info = force.parameters[static_cast<std::size_t>(c.parameter)];
  Json json = {{"mesh", c.mesh}, {"force", force.name}, {"parameter", info.name}, {"value", value_json(info, c.value)}};
  if (c.continues) json["continues"] = true;
  return json;
}
void read_keys(const JsonInput& in, SetForceParameter& c) {
  expect_keys(in, {"mesh", "force", "parameter", "value", "continues"});
  c.mesh = read_id(in["mesh"]);
  const std::string name = in["force"].text();
  const ForceInfo* const force = find_force(name.c_str());
  if (!force) in["force"].fail("the force " + unknown_name(name, names_of(force_list())), "correct it");
  c.force = force->id;
  read_value(in, force->parameters, c.parameter, c.value);
  c.continues = in.has("continues") && in["continues"].boolean();
}

Json keys_json(const SetSimulationParameter& c) {
  const ParameterInfo& info = simulation_table()[static_cast<std::size_t>(c.parameter)];
  Json json = {{"parameter", info.name}, {"value", value_json(info, c.value)}};
  if (c.continues) json["continues"] = true;
  return json;
}
void read_keys(const JsonInput& in, SetSimulationParameter& c) {
  expect_keys(in, {"parameter", "value", "continues"});
  read_value(in, simulation_table(), c.parameter, c.value);
  c.continues = in.has("continues") && in["continues"].boolean();
}

Json keys_json(const AddPoint& c) {
  Json json = {{"mesh", c.mesh}, {"position_mm", vector_json<Json>(c.position_mm)}};
  if (c.kind != MarkKind::Boundary) json["kind"] = name_of(c.kind);
  if (c.radius_mm > 0) json["radius_mm"] = c.radius_mm;
  if (c.outward.norm() > 0) json["outward"] = vector_json<Json>(c.outward);
  if (!c.path_mm.empty()) json["path_mm"] = path_json<Json>(c.path_mm);
  if (c.brush.paints()) json["paint"] = paint_json<Json>(c);
  if (c.local) json["local"] = true;
  return json;
}
void read_keys(const JsonInput& in, AddPoint& c) {
  expect_keys(in, {"mesh", "position_mm", "kind", "radius_mm", "outward", "path_mm", "paint", "local"});
  c = {read_id(in["mesh"]), in["position_mm"].vector3()};
  if (in.has("kind")) c.kind = read_point_kind(in["kind"]);
  if (in.has("radius_mm")) c.radius_mm = read_radius(in["radius_mm"]);
  if (in.has("outward")) c.outward = in["outward"].vector3();
  if (in.has("path_mm")) c.path_mm = read_path(in["path_mm"]);
  if (in.has("local")) c.local = in["local"].boolean();
  if (in.has("paint") && read_paint(in["paint"], c.brush, c.edit))
    in["paint"].fail("a command has no voxels", "use the stroke that determines them");
}

Json keys_json(const MovePoint& c) {
  Json json = {{"point", c.point}, {"position_mm", vector_json<Json>(c.position_mm)}};
  if (c.continues) json["continues"] = true;
  return json;
}
void read_keys(const JsonInput& in, MovePoint& c) {
  expect_keys(in, {"point", "position_mm", "continues"});
  c = {read_id(in["point"]), in["position_mm"].vector3(), in.has("continues") && in["continues"].boolean()};
}

Json keys_json(const ResizePoint& c) {
  Json json = {{"point", c.point}, {"radius_mm", c.radius_mm}};
  if (c.continues) json["continues"] = true;
  return json;
}
void read_keys(const JsonInput& in, ResizePoint& c) {
  expect_keys(in, {"point", "radius_mm", "continues"});
  c = {read_id(in["point"]), read_radius(in["radius_mm"]), in.has("continues") && in["continues"].boolean()};
}

Json keys_json(const AddMeasurement& c) { return measurement_json<Json>(c.kind, c.points_mm, c.name); }
void read_keys(const JsonInput& in, AddMeasurement& c) {
  expect_keys(in, {"kind", "points_mm", "name"});
  c.kind = read_measurement_kind(in["kind"]);
  c.points_mm = read_path(in["points_mm"]);
  if (in.has("name")) c.name = in["name"].text_or_empty();
}

Json keys_json(const MoveMeasurement& c) {
  Json json = {{"measurement", c.measurement}, {"points_mm", path_json<Json>(c.points_mm)}};
  if (c.continues) json["continues"] = true;
  return json;
}
void read_keys(const JsonInput& in, MoveMeasurement& c) {
  expect_keys(in, {"measurement", "points_mm", "continues"});
  c = {read_id(in["measurement"]), read_path(in["points_mm"]), in.has("continues") && in["continues"].boolean()};
}

Json keys_json(const RenameMeasurement& c) { return {{"measurement", c.measurement}, {"name", c.name}}; }
void read_keys(const JsonInput& in, RenameMeasurement& c) {
  expect_keys(in, {"measurement", "name"});
  c = {read_id(in["measurement"]), in["name"].text()};
}

Json keys_json(const DeleteMeasurement& c) { return {{"measurement", c.measurement}}; }
void read_keys(const JsonInput& in, DeleteMeasurement& c) {
  expect_keys(in, {"measurement"});
  c.measurement = read_id(in["measurement"]);
}

Json keys_json(const SetReference& c) {
  Json json = {{"mesh", c.mesh}};
  if (c.reference) json["labels"] = c.reference->labels;
  if (c.reference && c.reference->value) json["value"] = *c.reference->value;
  if (c.continues) json["continues"] = true;
  return json;
}
void read_keys(const JsonInput& in, SetReference& c) {
  expect_keys(in, {"mesh", "labels", "value", "continues"});
  c.mesh = read_id(in["mesh"]);
  if (in.has("labels")) c.reference = Reference{in["labels"].text(), std::nullopt};
  if (c.reference && in.has("value")) c.reference->value = in["value"].number();
  c.continues = in.has("continues") && in["continues"].boolean();
}

Json keys_json(const DeletePoint& c) { return {{"point", c.point}}; }
void read_keys(const JsonInput& in, DeletePoint& c) {
  expect_keys(in, {"point"});
  c.point = read_id(in["point"]);
}

Json keys_json(const SetParameters& c) {
  Json json = {{"mesh", c.mesh}, {"forces", forces_json<Json>(c.forces, nullptr)}};
  if (c.simulation) json["simulation"] = simulation_json<Json>(*c.simulation);
  return json;
}
void read_keys(const JsonInput& in, SetParameters& c) {
  expect_keys(in, {"mesh", "forces", "simulation"});
  c = {read_id(in["mesh"]), default_force_parameters(), std::nullopt};
  read_forces(in["forces"], c.forces);
  if (!in.has("simulation")) return;
  c.simulation = default_simulation_parameters();
  read_simulation(in["simulation"], *c.simulation);
}

Json keys_json(const AddLasso& c) {
  Json json = {{"mesh", c.mesh},
               {"kind", name_of(c.kind)},
               {"contour_mm", path_json<Json>(c.contour_mm)},
               {"normal", vector_json<Json>(c.normal)}};
  if (c.local) json["local"] = true;
  return json;
}
void read_keys(const JsonInput& in, AddLasso& c) {
  expect_keys(in, {"mesh", "kind", "contour_mm", "normal", "local"});
  c = {read_id(in["mesh"]), read_point_kind(in["kind"]), read_path(in["contour_mm"]), in["normal"].vector3()};
  c.local = in.has("local") && in["local"].boolean();
}

Json keys_json(const SetIntensityRange& c) {
  Json json = {{"mesh", c.mesh}, {"range", range_json<Json>(c.range)}};
  if (c.continues) json["continues"] = true;
  return json;
}
void read_keys(const JsonInput& in, SetIntensityRange& c) {
  expect_keys(in, {"mesh", "range", "continues"});
  c = {read_id(in["mesh"]), read_range(in["range"])};
  c.continues = in.has("continues") && in["continues"].boolean();
}

// Commands of models, in mesh_model.h.
template <class C>
concept ModelCommand =
    std::is_same_v<C, SetModel> || std::is_same_v<C, SetStartModes> || std::is_same_v<C, RecordProfiles>;
Json keys_json(const ModelCommand auto& c) { return model_keys_json<Json>(c); }
void read_keys(const JsonInput& in, ModelCommand auto& c) { read_model_keys(in, c); }

Json keys_json(const SetStart& c) { return set_start_json<Json>(c); }
void read_keys(const JsonInput& in, SetStart& c) { read_set_start(in, c); }

Json keys_json(const EditVoxels& c) {
  const VoxelEditInfo& info = info_of(c.edit);
  Json json = {{"mesh", c.mesh}, {"edit", info.name}};
  if (info.size.name[0] != '\0') json["size"] = c.size;
  if (info.uses_other) json["other"] = c.other;
  return json;
}
void read_keys(const JsonInput& in, EditVoxels& c) {
  expect_keys(in, {"mesh", "edit", "size", "other"});
  c = {read_id(in["mesh"]), read_voxel_edit(in["edit"])};
  if (in.has("size")) c.size = in["size"].number();
  if (in.has("other")) c.other = read_id(in["other"]);
}

Json keys_json(const ReorderMesh& c) { return {{"mesh", c.mesh}, {"place", c.place}}; }
void read_keys(const JsonInput& in, ReorderMesh& c) {
  expect_keys(in, {"mesh", "place"});
  c = {read_id(in["mesh"]), in["place"].integer_between(0, kMaxInt)};
}

template <class C>
concept MeshCommand =
    std::is_same_v<C, DeleteMesh> || std::is_same_v<C, StartFieldUpdate> || std::is_same_v<C, ResetPose> ||
    std::is_same_v<C, RefineMesh> || std::is_same_v<C, DuplicateMesh> || std::is_same_v<C, RequestFieldUpdate> ||
    std::is_same_v<C, StartFieldComparison> || std::is_same_v<C, CommitFieldComparison>;
Json keys_json(const MeshCommand auto& c) { return {{"mesh", c.mesh}}; }
void read_keys(const JsonInput& in, MeshCommand auto& c) {
  expect_keys(in, {"mesh"});
  c.mesh = read_id(in["mesh"]);
}

Json keys_json(const LayerCommand auto& c) { return layer_keys_json<Json>(c); }
void read_keys(const JsonInput& in, LayerCommand auto& c) { read_layer_keys(in, c); }

template <class C>
concept EmptyCommand = std::is_empty_v<C>;
Json keys_json(const EmptyCommand auto&) { return Json::object(); }
void read_keys(const JsonInput& in, EmptyCommand auto&) { expect_keys(in, {}); }

/// Names of the commands in files, in the order of the alternatives of Command.
const std::vector<std::string> kNames = {"add_mesh",
                                         "delete_mesh",
                                         "edit_mesh",
                                         "set_force_parameter",
                                         "set_simulation_parameter",
                                         "add_point",
                                         "move_point",
                                         "delete_point",
                                         "reset_pose",
                                         "record_profiles",
                                         "refine_mesh",
                                         "duplicate_mesh",
                                         "place_mesh",
                                         "set_parameters",
                                         "start_field_update",
                                         "commit_field_update",
                                         "undo",
                                         "redo",
                                         "set_reference",
                                         "resize_point",
                                         "cancel_field_update",
                                         "request_field_update",
                                         "commit_preliminary_field",
                                         "start_field_comparison",
                                         "commit_field_comparison",
                                         "edit_voxels",
                                         "choose_label_preset",
                                         "add_measurement",
                                         "move_measurement",
                                         "rename_measurement",
                                         "delete_measurement",
                                         "add_lasso",
                                         "set_intensity_range",
                                         "set_model",
                                         "add_layer",
                                         "edit_layer",
                                         "remove_layer",
                                         "filter_volume",
                                         "set_images",
                                         "set_start_modes",
                                         "set_start"};
/// Earlier names of commands, in logs and histories of previous versions.
const std::map<std::string, std::string> kEarlierNames = {{"learn_field", "start_field_update"},
                                                          {"take_field", "commit_field_update"}};

template <std::size_t I = 0>
Command read_body(const JsonInput& input, std::size_t index) {
  if constexpr (I + 1 < std::variant_size_v<Command>) {
    if (index != I) return read_body<I + 1>(input, index);
  }
  std::variant_alternative_t<I, Command> command{};
  read_keys(input, command);
  return command;
}

/// Adds the name and the keys of a command to a JSON object.
void add_command(Json& json, const Command& command) {
  json["command"] = kNames.at(command.index());
  json.update(std::visit([](const auto& one) { return keys_json(one); }, command));
}

}  // namespace

std::string command_text(const Command& command) {
  Json json = Json::object();
  add_command(json, command);
  return json.dump();
}

Command read_command(const JsonInput& input) {
  std::string name = input["command"].text();
  if (const auto earlier = kEarlierNames.find(name); earlier != kEarlierNames.end()) name = earlier->second;
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) input["command"].fail("the command " + unknown_name(name, kNames), "correct it");
  return read_body(input, static_cast<std::size_t>(found - kNames.begin()));
}

void write_log(const fs::path& path, const std::vector<LogEntry>& log, int trailing_steps, const std::string& scene) {
  AtomicFile file(path);
  Json json = {{"simplexseg_log", 1}};
  if (!scene.empty()) json["scene"] = scene;
  json["entries"] = Json::array();
  for (const LogEntry& entry : log) {
    Json line = {{"after_steps", entry.steps}};
    add_command(line, entry.command);
    json["entries"].push_back(std::move(line));
  }
  json["trailing_steps"] = trailing_steps;
  write_bytes(file, json_text(path, json));
  file.commit();
}

LogFile read_log(const fs::path& path) {
  const JsonInput input = JsonInput::open(path, "log");
  if (!input.has("simplexseg_log"))
    input.fail("it is not a log: the key 'simplexseg_log' is missing", "choose a log file");
  input["simplexseg_log"].integer_between(1, 1);
  input.expect_keys({"simplexseg_log", "scene", "entries", "trailing_steps"});
  LogFile file{};
  if (input.has("scene")) file.scene = input["scene"].text();
  int steps_left = kMaxSteps;  // for all entries together
  const auto read_steps = [&steps_left](const char* key, const JsonInput& in) {
    const int steps = in[key].integer_between(0, steps_left);
    steps_left -= steps;
    return steps;
  };
  const JsonInput entries = input["entries"];
  for (int e = 0; e < entries.size(); ++e) {
    const JsonInput entry = entries[e];
    const int steps = read_steps("after_steps", entry);
    Command command = read_command(entry);
    load_start_of(command);
    file.log.push_back({steps, std::move(command)});
  }
  file.trailing_steps = read_steps("trailing_steps", input);
  return file;
}

}  // namespace simplexseg
