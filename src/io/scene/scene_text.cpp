// SPDX-License-Identifier: Apache-2.0
#include "io/scene/scene_text.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/scene/code_text.h"
#include "io/scene/colour_text.h"
#include "io/scene/json_input.h"
#include "io/scene/json_output.h"
#include "io/scene/label_numbers.h"
#include "io/scene/layer_text.h"
#include "io/scene/log_io.h"
#include "io/scene/mesh_model.h"
#include "io/scene/mesh_start.h"
#include "io/scene/parameter_json.h"
#include "io/scene/parameter_text.h"
#include "io/scene/point_text.h"
#include "io/volume/volume_io.h"
#include "session/free_attributes.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kSceneVersion = 1;
constexpr int kMaxLabel = 65535;

/// Whether a label preset is named by the path of its file.
bool is_preset_file(const std::string& preset) { return preset.ends_with(".json"); }

// ---- reading ----

MeshItem read_item(const JsonInput& input, const Scene& scene, const fs::path& folder, const MeshReader& read_files) {
  input.expect_keys({"name", "sphere", "start", "colour", "visible", "locked", "opacity", "label", "code", "forces",
                     "final_vertices", "intensity_range", "images", "model", "start_modes", "model_profiles",
                     "reference", "pose", "state"});
  MeshItem item;
  item.name = input["name"].text();
  if (input.has("final_vertices")) {
    const ParameterInfo& info = simulation_table()[find_parameter(simulation_table(), "final_vertices")];
    item.final_vertices = static_cast<int>(input["final_vertices"].parameter(info));
  }
  item.parameters = scene.forces;
  read_files(input, item);
  if (input.has("sphere") || !input.has("start")) {
    const JsonInput sphere = input["sphere"];
    sphere.expect_keys({"centre_mm", "radius_mm"});
    item.seed.centre_mm = sphere["centre_mm"].vector3();
    item.seed.radius_mm = read_radius(sphere["radius_mm"]);
  }
  if (input.has("colour")) item.colour = read_colour_text(input["colour"]);
  if (input.has("visible")) item.visible = input["visible"].boolean();
  if (input.has("locked")) item.locked = input["locked"].boolean();
  if (input.has("opacity")) {
    item.opacity = static_cast<float>(input["opacity"].number());
    if (!(item.opacity > 0 && item.opacity <= 1)) input["opacity"].fail("it is out of range", "use 0.1 to 1");
  }
  if (input.has("label")) item.label = input["label"].integer_between(1, kMaxLabel);
  if (input.has("code")) item.code = read_code(input["code"]);
  if (input.has("forces")) read_forces(input["forces"], item.parameters);
  if (input.has("intensity_range")) item.intensity_range = read_range(input["intensity_range"]);
  if (input.has("images")) item.images = images_from_json(input["images"]);
  if (input.has("model")) item.model = mesh_model_from_json(input["model"], folder);
  if (input.has("start_modes")) item.start_modes = read_modes(input["start_modes"]);
  if (input.has("model_profiles")) item.model_profiles = input["model_profiles"].boolean();
  if (input.has("reference")) {
    const JsonInput reference = input["reference"];
    reference.expect_keys({"labels", "value"});
    item.reference = Reference{absolute_if_found(reference["labels"].text(), folder), std::nullopt};
    if (reference.has("value")) item.reference->value = reference["value"].number();
  }
  return item;
}

/// Gives the meshes without a colour different colours of the palette.
void colour_meshes(const JsonInput& input, Scene& scene) {
  const auto has_colour = [&](std::size_t mesh) { return input["meshes"][static_cast<int>(mesh)].has("colour"); };
  std::vector<Colour> used;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    if (has_colour(m)) used.push_back(scene.meshes[m].colour);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (has_colour(m)) continue;
    scene.meshes[m].colour = free_colour(used);
    used.push_back(scene.meshes[m].colour);
  }
}

SavedView read_view(const JsonInput& input) {
  input.expect_keys({"crosshair_mm", "window", "level", "active_mesh"});
  SavedView view;
  view.crosshair_mm = input["crosshair_mm"].vector3();
  view.window = input["window"].number();
  view.level = input["level"].number();
  if (!(view.window > 0)) input["window"].fail("it is not above 0", "use a width of the intensity window above 0");
  if (input.has("active_mesh")) view.active_mesh = input["active_mesh"].text();
  return view;
}

UserPoint read_point(const JsonInput& input, const Scene& scene) {
  input.expect_keys({"mesh", "position_mm", "kind", "radius_mm", "outward", "path_mm", "paint", "continues", "local",
                     "lasso_normal"});
  const std::string name = input["mesh"].text();
  const MeshItem* const item = scene.find_mesh(name);
  if (!item) {
    std::vector<std::string> names;
    for (const MeshItem& mesh : scene.meshes) names.push_back(mesh.name);
    input["mesh"].fail("the mesh " + unknown_name(name, names), "use the name of a mesh in this scene");
  }
  UserPoint point{0, item->id, input["position_mm"].vector3()};
  if (input.has("kind")) point.kind = read_point_kind(input["kind"]);
  if (input.has("radius_mm")) point.radius_mm = read_radius(input["radius_mm"]);
  if (input.has("outward")) point.outward = input["outward"].vector3();
  if (input.has("path_mm")) point.path_mm = read_path(input["path_mm"]);
  if (input.has("continues")) point.continues = input["continues"].boolean();
  if (input.has("lasso_normal")) {
    point.lasso_normal = input["lasso_normal"].vector3();
    if (!point.is_lasso()) input["lasso_normal"].fail("it is 0", "give the unit normal of its slice");
  }
  if (input.has("local")) point.local = input["local"].boolean();
  if (input.has("paint")) point.voxels = read_paint(input["paint"], point.brush, point.edit);
  return point;
}

Measurement read_measurement(const JsonInput& input) {
  input.expect_keys({"name", "kind", "points_mm"});
  Measurement measurement{0, read_measurement_kind(input["kind"]), read_path(input["points_mm"]), input["name"].text()};
  if (const std::optional<std::string> defect = defect_of(measurement.kind, measurement.points_mm))
    input["points_mm"].fail(*defect, "correct it");
  return measurement;
}

// ---- writing ----

/// Path relative to `folder` if the file is in it, so that the folder can be moved; else absolute. A relative path of a
/// missing file is returned unchanged.
std::string portable(const std::string& path, const fs::path& folder) {
  std::error_code failure;
  fs::path place(path);
  if (place.is_relative()) {
    if (path.empty() || !fs::exists(place, failure)) return path;
    place = fs::absolute(place);
  }
  const fs::path beside = fs::absolute(folder.empty() ? "." : folder).lexically_normal();
  const fs::path relative = place.lexically_normal().lexically_relative(beside);
  return relative.empty() || *relative.begin() == ".." ? place.lexically_normal().string() : relative.string();
}

/// `number_of_layer`: number in the file of the layer with an id.
Json item_json(const MeshItem& item, const ForceParameters& defaults, const fs::path& folder,
               const std::function<ItemId(ItemId)>& number_of_layer) {
  Json json = {{"name", item.name},
               {"sphere", {{"centre_mm", vector_json<Json>(item.seed.centre_mm)}, {"radius_mm", item.seed.radius_mm}}},
               {"colour", colour_text(item.colour)},
               {"visible", item.visible},
               {"label", item.label}};
  if (item.start) json["start"] = start_json<Json>(*item.start, portable(item.start->path, folder));
  if (!item.code.empty()) json["code"] = code_json<Json>(item.code);
  if (item.locked) json["locked"] = true;
  if (item.opacity < 1) json["opacity"] = item.opacity;
  const Json forces = forces_json<Json>(item.parameters, &defaults);
  if (!forces.empty()) json["forces"] = forces;
  if (item.final_vertices > 0) json["final_vertices"] = item.final_vertices;
  if (item.intensity_range.is_limited()) json["intensity_range"] = range_json<Json>(item.intensity_range);
  if (!item.images.is_default()) json["images"] = images_json<Json>(item.images, number_of_layer);
  if (item.model) json["model"] = mesh_model_json<Json>(*item.model, portable(item.model->path, folder));
  if (!item.start_modes.empty()) json["start_modes"] = item.start_modes;
  if (item.model_profiles) json["model_profiles"] = true;
  if (item.reference) {
    json["reference"] = {{"labels", portable(item.reference->labels, folder)}};
    if (item.reference->value) json["reference"]["value"] = *item.reference->value;
  }
  return json;
}

Json view_json(const SavedView& view) {
  Json json = {{"crosshair_mm", vector_json<Json>(view.crosshair_mm)}, {"window", view.window}, {"level", view.level}};
  if (!view.active_mesh.empty()) json["active_mesh"] = view.active_mesh;
  return json;
}

Json point_json(const UserPoint& point, const Scene& scene) {
  Json json = {{"mesh", scene.find_mesh(point.mesh)->name}, {"position_mm", vector_json<Json>(point.position_mm)}};
  if (point.kind != MarkKind::Boundary) json["kind"] = name_of(point.kind);
  if (point.radius_mm > 0) json["radius_mm"] = point.radius_mm;
  if (point.outward.norm() > 0) json["outward"] = vector_json<Json>(point.outward);
  if (point.is_stroke()) json["path_mm"] = path_json<Json>(point.path_mm);
  if (point.is_lasso()) json["lasso_normal"] = vector_json<Json>(point.lasso_normal);
  if (point.continues) json["continues"] = true;
  if (point.local) json["local"] = true;
  if (point.is_paint()) json["paint"] = paint_json<Json>(point);
  return json;
}

/// Throws Error for a scene that cannot be saved. Points refer to their mesh by its name, so names must be unique.
void expect_writable(const fs::path& path, const Scene& scene) {
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const std::string& name = scene.meshes[m].name;
    if (name.empty()) throw Error("cannot write " + quoted(path), "a segmentation has no name", "name it");
    const bool twice = std::any_of(scene.meshes.begin(), scene.meshes.begin() + static_cast<std::ptrdiff_t>(m),
                                   [&name](const MeshItem& other) { return other.name == name; });
    if (twice)
      throw Error("cannot write " + quoted(path), "two segmentations have the name '" + one_line(name) + "'",
                  "rename one");
  }
  for (const UserPoint& point : scene.points) {
    if (!scene.find_mesh(point.mesh)) {
      throw Error("cannot write " + quoted(path), "a mark belongs to no segmentation", "delete the mark");
    }
  }
}

}  // namespace

std::string absolute_if_found(const std::string& path, const fs::path& folder) {
  std::error_code failure;
  for (const fs::path& place : {fs::path(path), folder / path}) {
    if (fs::exists(place, failure)) return fs::absolute(place).lexically_normal().string();
  }
  return path;
}

Scene scene_of(const JsonInput& input, const fs::path& folder, const MeshReader& read_files) {
  if (!input.has("simplexseg_scene"))
    input.fail("it is not a scene: the key 'simplexseg_scene' is missing", "choose a scene file");
  input["simplexseg_scene"].integer_between(kSceneVersion, kSceneVersion);
  input.expect_keys({"simplexseg_scene", "volume", "volume_number", "series", "volume_checksum", "preprocessing",
                     "simulation", "forces", "meshes", "points", "measurements", "layers", "steps", "view", "labels"});
  Scene scene;
  scene.simulation = default_simulation_parameters();
  if (input.has("volume")) scene.volume_path = absolute_if_found(input["volume"].text(), folder);
  if (input.has("volume_number")) scene.volume_number = input["volume_number"].integer_between(1, kMaxVolumes);
  if (input.has("volume_checksum")) scene.volume_checksum = input["volume_checksum"].text();
  if (input.has("preprocessing")) scene.volume_preprocessing = preprocessing_from_json(input["preprocessing"]);
  if (input.has("view")) scene.view = read_view(input["view"]);
  if (input.has("series")) scene.volume_series = input["series"].text();
  if (input.has("simulation")) read_simulation(input["simulation"], scene.simulation);
  if (input.has("forces")) read_forces(input["forces"], scene.forces);
  const int mesh_count = input.has("meshes") ? input["meshes"].size() : 0;
  for (int m = 0; m < mesh_count; ++m) {
    MeshItem item = read_item(input["meshes"][m], scene, folder, read_files);
    item.id = static_cast<ItemId>(m + 1);
    if (scene.find_mesh(item.name)) {
      input["meshes"][m]["name"].fail("two meshes have the name '" + one_line(item.name) + "'", "rename one");
    }
    scene.meshes.push_back(std::move(item));
  }
  colour_meshes(input, scene);
  constexpr std::size_t kMostPaintedVoxels = std::size_t{1} << 29;  // in the boxes of all sets
  std::size_t painted = 0;
  const int point_count = input.has("points") ? input["points"].size() : 0;
  for (int p = 0; p < point_count; ++p) {
    scene.points.push_back(read_point(input["points"][p], scene));
    if (const auto& set = scene.points.back().voxels) painted += set->voxels.size();
    if (painted > kMostPaintedVoxels)
      input["points"].fail("its sets of painted voxels are too large", "use at most 2^29 voxels in all boxes together");
    scene.points.back().id = static_cast<ItemId>(mesh_count + p + 1);
  }
  if (input.has("labels")) {
    input["labels"].expect_keys({"preset", "by_name"});
    scene.labels = read_labels(input["labels"]);
    if (is_preset_file(scene.labels.preset)) scene.labels.preset = absolute_if_found(scene.labels.preset, folder);
  }
  const int measurement_count = input.has("measurements") ? input["measurements"].size() : 0;
  for (int m = 0; m < measurement_count; ++m) {
    scene.measurements.push_back(read_measurement(input["measurements"][m]));
    scene.measurements.back().id = static_cast<ItemId>(mesh_count + point_count + m + 1);
  }
  const int layer_count = input.has("layers") ? input["layers"].size() : 0;
  for (int n = 0; n < layer_count; ++n) {
    scene.layers.push_back(layer_from_json(input["layers"][n], folder));
    scene.layers.back().id = static_cast<ItemId>(mesh_count + point_count + measurement_count + n + 1);
  }
  const auto layer_id = [&](ItemId number) {  // of the number in the file
    if (number > scene.layers.size())
      input["meshes"].fail("a segmentation is computed with layer " + std::to_string(number) + ", which is missing",
                           "add that layer to the file");
    return number == 0 ? 0 : scene.layers[number - 1].id;
  };
  for (MeshItem& item : scene.meshes) {
    item.images.main = layer_id(item.images.main);
    for (ItemId& id : item.images.further) id = layer_id(id);
  }
  if (input.has("steps")) scene.steps = input["steps"].integer_between(0, kMaxSteps);
  return scene;
}

std::string scene_text(const fs::path& path, const Scene& scene, const std::vector<std::string>& poses, int indent) {
  expect_writable(path, scene);
  const fs::path folder = path.parent_path();
  Json json = {{"simplexseg_scene", kSceneVersion}};
  if (!scene.volume_path.empty()) json["volume"] = portable(scene.volume_path, folder);
  if (scene.volume_number != 1) json["volume_number"] = scene.volume_number;
  if (!scene.volume_series.empty()) json["series"] = scene.volume_series;
  if (!scene.volume_checksum.empty()) json["volume_checksum"] = scene.volume_checksum;
  if (!scene.volume_preprocessing.filters.empty())
    json["preprocessing"] = preprocessing_json<Json>(scene.volume_preprocessing);
  json["simulation"] = simulation_json<Json>(scene.simulation);
  json["forces"] = forces_json<Json>(scene.forces, nullptr);
  json["meshes"] = Json::array();
  const auto number_of_layer = [&](ItemId id) {  // from 1; 0: the volume
    const auto at = std::ranges::find(scene.layers, id, &LayerItem::id);
    return id == 0 ? 0 : static_cast<ItemId>(at - scene.layers.begin() + 1);
  };
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    Json entry = item_json(scene.meshes[m], scene.forces, folder, number_of_layer);
    if (m < poses.size() && !poses[m].empty()) entry["pose"] = poses[m] + ".ply", entry["state"] = poses[m] + ".state";
    json["meshes"].push_back(std::move(entry));
  }
  json["points"] = Json::array();
  for (const UserPoint& point : scene.points) json["points"].push_back(point_json(point, scene));
  for (const Measurement& m : scene.measurements)
    json["measurements"].push_back(measurement_json<Json>(m.kind, m.points_mm, m.name));
  for (const LayerItem& layer : scene.layers)
    json["layers"].push_back(layer_json<Json>(layer, [&](const std::string& file) { return portable(file, folder); }));
  json["steps"] = scene.steps;
  if (scene.view) json["view"] = view_json(*scene.view);
  LabelNumbers labels = scene.labels;
  if (is_preset_file(labels.preset)) labels.preset = portable(labels.preset, folder);
  if (const Json object = labels_json<Json>(labels); !object.empty()) json["labels"] = object;
  return json_text(path, json, indent);
}

}  // namespace simplexseg
