// SPDX-License-Identifier: Apache-2.0
#include "cli/segment_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "core/number_text.h"
#include "io/labels/label_file.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/scene/label_preset.h"
#include "io/scene/mesh_model.h"
#include "io/scene/mesh_start.h"
#include "model/model_prior.h"
#include "model/model_start.h"
#include "session/free_attributes.h"
#include "session/scene_checks.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

std::string counted_meshes(const Scene& scene) { return counted(scene.meshes.size(), "mesh", "meshes"); }

Eigen::Vector3d position_of(const char* option, const std::string& text) {
  Eigen::Vector3d position;
  std::size_t start = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t end = axis < 2 ? text.find(',', start) : text.size();
    const std::optional<double> value =
        end == text.npos ? std::nullopt : number_of<double>(trimmed(text.substr(start, end - start)));
    if (!value || !std::isfinite(*value))
      throw Error(std::string(option) + " '" + one_line(text, 100) + "'", "it is not three numbers separated by commas",
                  "write X,Y,Z in mm (LPS), for example -12.5,30,8");
    position[axis] = *value;
    start = end + 1;
  }
  return position;
}

/// Reads a template scene, without the data that belongs to the image of the template.
Scene template_scene(const std::string& path) {
  Scene scene = read_scene(path, SceneVolume::Skip).scene;
  scene.volume_checksum.clear(), scene.volume_series.clear(), scene.view.reset();
  for (MeshItem& item : scene.meshes) {
    MeshItem copy;
    copy.id = item.id, copy.name = item.name, copy.label = item.label, copy.code = item.code;
    copy.colour = item.colour, copy.visible = item.visible, copy.locked = item.locked, copy.opacity = item.opacity;
    copy.seed = item.seed, copy.start = item.start;
    copy.parameters = item.parameters, copy.final_vertices = item.final_vertices;
    item = std::move(copy);
  }
  return scene;
}

MeshItem& add_mesh_item(Scene& scene) {
  MeshItem item;
  item.name = free_name(scene), item.label = free_label(scene), item.colour = free_colour(scene);
  item.parameters = scene.forces;
  return scene.meshes.emplace_back(std::move(item));
}

void place_seeds(const SegmentRequest& request, Scene& scene) {
  const std::size_t count = request.seeds.size(), radii = request.radii.size();
  if (radii > 1 && radii != count)
    throw Error("--radius", counted(radii, "radius", "radii") + " for " + counted(count, "seed", "seeds"),
                "use one for all seeds, or one per seed");
  if (!scene.meshes.empty() && scene.meshes.size() != count)
    throw Error(
        "--seed",
        counted(count, "seed", "seeds") + " for " + counted_meshes(scene) + " of " + quoted(fs::path(request.scene)),
        "use one seed per mesh, in the order of the scene");
  for (std::size_t s = 0; s < count; ++s) {
    MeshItem& item = s < scene.meshes.size() ? scene.meshes[s] : add_mesh_item(scene);
    item.seed.centre_mm = position_of("--seed", request.seeds[s]);
    item.seed.radius_mm = radii == 0 ? Seed().radius_mm : request.radii[radii == 1 ? 0 : s];
    item.start.reset();
  }
}

/// Returns the value of a label as the label of a mesh. Throws Error for a value that written labels cannot hold.
int label_number(double value, const std::string& path) {
  if (value >= 1 && value <= 65535 && value == std::round(value)) return static_cast<int>(value);
  throw Error("cannot start from the labels " + quoted(fs::path(path)),
              "they contain the label " + general_text(value, 15) + ", but labels are whole numbers from 1 to 65535",
              "renumber the labels");
}

/// Returns the name of a label, distinct from those of the meshes of the scene.
std::string mesh_name(const LabelCount& label, int number, const Scene& scene) {
  std::string by_number = "label " + std::to_string(number);
  if (label.name.empty()) return by_number;
  return scene.find_mesh(label.name) ? label.name + " (" + by_number + ")" : label.name;
}

void start_from_labels(const SegmentRequest& request, SceneFile& file) {
  const std::string path = fs::absolute(request.start_labels).lexically_normal().string();
  LabelFile labels(path);
  Scene& scene = file.scene;
  if (scene.meshes.empty()) {
    for (const LabelCount& label : labels.count()) {
      const int number = label_number(label.value, request.start_labels);
      const std::string name = mesh_name(label, number, scene);
      MeshItem& item = add_mesh_item(scene);
      item.label = number, item.name = name, item.code = label.code;
      if (label.colour) item.colour = *label.colour;
    }
    if (scene.meshes.empty())
      throw Error("labels " + quoted(fs::path(request.start_labels)), "every voxel is 0",
                  "choose another label volume");
  }
  for (MeshItem& item : scene.meshes) {
    const LabelChoice choice{.label = static_cast<double>(item.label)};
    const LoadedLabels& chosen = labels.labels(choice);
    for (const std::string& warning : chosen.warnings)
      if (std::find(file.warnings.begin(), file.warnings.end(), warning) == file.warnings.end())
        file.warnings.push_back(warning);
    LoadedStart loaded = start_of_labels(chosen.volume, choice, path, item.final_vertices);
    item.start = std::move(loaded.start), item.seed = loaded.seed;
  }
}

void rename_meshes(const std::vector<std::string>& names, Scene& scene) {
  if (names.empty()) return;
  if (names.size() != scene.meshes.size())
    throw Error("--name", counted(names.size(), "name", "names") + " for " + counted_meshes(scene),
                "use one name per mesh");
  for (std::size_t m = 0; m < names.size(); ++m) {
    if (names[m].empty()) throw Error("--name", "a name is empty", "name every mesh");
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(m), names[m]) !=
        names.begin() + static_cast<std::ptrdiff_t>(m))
      throw Error("--name '" + one_line(names[m]) + "'", "two meshes would have this name", "choose different names");
    scene.meshes[m].name = names[m];
  }
}

void set_models(const std::vector<std::string>& paths, Scene& scene) {
  if (paths.empty()) return;
  if (paths.size() > 1 && paths.size() != scene.meshes.size())
    throw Error("--model", counted(paths.size(), "model", "models") + " for " + counted_meshes(scene),
                "use one for all, or one per mesh");
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    MeshItem& item = scene.meshes[m];
    if (m == 0 || paths.size() > 1)
      item.model = load_mesh_model(fs::absolute(paths[m]).lexically_normal().string(), {});
    else
      item.model = scene.meshes[0].model;
    check_model(item, item.model.get());
  }
}

/// Meshes of the organs of a model of several: those that are wanted, and those of the seeds.
void add_organs(const SegmentRequest& request, const ModelFile& model, const std::string& path, Scene& scene) {
  const std::string file = quoted(fs::path(path));
  if (!request.scene.empty() || !request.start_labels.empty())
    throw Error("model " + file, "it has several organs, but the meshes start from a scene or labels",
                "leave them out, or use a model of one organ for each mesh");
  const std::size_t seeds = request.seeds.size(), radii = request.radii.size();
  if (request.seed_organs.size() != seeds)
    throw Error("--seed-organ",
                counted(request.seed_organs.size(), "organ", "organs") + " for " + counted(seeds, "seed", "seeds"),
                "name the organ of each seed, for example '" + model.organs.front().name + "'");
  if (radii > 1 && radii != seeds)
    throw Error("--radius", counted(radii, "radius", "radii") + " for " + counted(seeds, "seed", "seeds"),
                "use one for all seeds, or one per seed");
  std::vector<bool> wanted(model.organs.size(), request.organs.empty());
  for (const std::string& name : request.organs) wanted[organ_of_name(model, name, file)] = true;
  std::vector<std::optional<Seed>> placed(model.organs.size());
  for (std::size_t s = 0; s < seeds; ++s) {
    std::optional<Seed>& seed = placed[organ_of_name(model, request.seed_organs[s], file)];
    if (seed)
      throw Error("--seed-organ '" + one_line(request.seed_organs[s], 100) + "'", "it has two seeds", "use one");
    seed = Seed{position_of("--seed", request.seeds[s]),
                radii == 0 ? Seed().radius_mm : request.radii[radii == 1 ? 0 : s]};
  }
  for (std::size_t k = 0; k < model.organs.size(); ++k) {
    if (!wanted[k] && !placed[k]) continue;
    MeshItem& item = add_mesh_item(scene);
    item.name = model.organs[k].name;
    item.model = mesh_model_of(model, path, static_cast<int>(k));
    if (placed[k]) item.seed = *placed[k];
  }
}

/// Model of several organs of the options; nothing for other models.
std::optional<ModelFile> model_of_several(const SegmentRequest& request) {
  if (request.models.size() != 1) return std::nullopt;
  ModelFile model = read_model(request.models.front());
  if (model.organs.size() < 2) return std::nullopt;
  return model;
}

/// Sets the preset of the scene. Meshes whose name has the words of a structure get its label, colour and codes.
void set_label_preset(const std::string& name_or_path, Scene& scene) {
  if (name_or_path.empty()) return;
  const LabelPreset preset = find_label_preset(name_or_path);
  LabelNumbers labels{preset.name, preset.by_name()};
  for (MeshItem& item : scene.meshes) {
    const PresetLabel* const label = find_label(preset.labels, item.name);
    const auto has = [&](const MeshItem& other) { return &other != &item && other.label == label->label; };
    if (!label) continue;
    item.colour = label->colour, item.code = label->code;
    // "kidney_left" gets the label of "Left kidney", unless another mesh is named so.
    if (!scene.find_mesh(label->name) && std::none_of(scene.meshes.data(), &item, has)) {
      item.label = label->label;
      labels.by_name.erase(label->name), labels.by_name[item.name] = item.label;
    }
  }
  set_labels(scene, std::move(labels));
}

void add_points(const char* option, const std::vector<std::string>& texts, MarkKind kind, Scene& scene) {
  for (const std::string& text : texts) {
    const std::size_t split = text.rfind('=');
    const MeshItem* item = nullptr;
    if (split != text.npos) {
      item = scene.find_mesh(text.substr(0, split));
      if (!item)
        throw Error(std::string(option) + " '" + one_line(text, 100) + "'", "no mesh has this name",
                    "name one of the meshes");
    } else if (scene.meshes.size() == 1) {
      item = &scene.meshes.front();
    } else {
      throw Error(std::string(option) + " '" + one_line(text, 100) + "'",
                  "the scene has " + counted_meshes(scene) + ", but the point names no mesh",
                  "write MESH=X,Y,Z, for example '" + scene.meshes.front().name + "=-12.5,30,8'");
    }
    UserPoint point{0, item->id, position_of(option, split == text.npos ? text : text.substr(split + 1))};
    point.kind = kind;
    scene.points.push_back(point);
  }
}

void set_references(const SegmentRequest& request, Scene& scene) {
  if (request.reference.empty()) {
    if (request.reference_label) throw Error("--reference-label", "there is no reference", "add --reference");
    return;
  }
  const std::string path = fs::absolute(request.reference).lexically_normal().string();
  for (MeshItem& item : scene.meshes) {
    std::optional<double> value = request.reference_label;
    if (!value && scene.meshes.size() > 1) value = item.label;
    item.reference = Reference{path, value};
  }
}

}  // namespace

SceneFile segment_scene(const SegmentRequest& request) {
  SceneFile file;
  Scene& scene = file.scene;
  if (request.scene.empty())
    scene.simulation = default_simulation_parameters();
  else
    scene = template_scene(request.scene);
  const std::optional<ModelFile> several = model_of_several(request);
  if (!several && !(request.organs.empty() && request.seed_organs.empty()))
    throw Error(request.organs.empty() ? "--seed-organ" : "--organ", "there is no model of several organs",
                "add one with --model, or leave the option out");
  if (several)
    add_organs(request, *several, fs::absolute(request.models.front()).lexically_normal().string(), scene);
  else if (!request.seeds.empty())
    place_seeds(request, scene);
  else if (!request.radii.empty() && request.start_labels.empty() && scene.meshes.empty())
    throw Error("segment", "there is a radius, but no seed", "add --seed X,Y,Z in mm (LPS)");
  else if (!request.start_labels.empty())
    start_from_labels(request, file);
  else if (starts_from_models(request))
    for (std::size_t m = 0; m < request.models.size(); ++m) add_mesh_item(scene);
  else if (scene.meshes.empty())
    throw Error("segment", "the position of the object is missing",
                "use --seed X,Y,Z and --radius, --labels-start LABELS, a --scene with meshes, or a --model");
  ItemId id = 0;
  for (MeshItem& item : scene.meshes) item.id = ++id;  // does not change a template, whose ids are 1, 2, ... already
  rename_meshes(request.names, scene);
  if (!several) set_models(request.models, scene);
  set_label_preset(request.label_preset, scene);
  add_points("--inside", request.inside, MarkKind::Inside, scene);
  add_points("--outside", request.outside, MarkKind::Outside, scene);
  add_points("--boundary", request.boundary, MarkKind::Boundary, scene);
  for (UserPoint& point : scene.points) point.id = ++id;
  set_references(request, scene);
  scene.volume_path = fs::absolute(request.image).lexically_normal().string();
  scene.volume_number = request.volume_number;
  scene.volume_series = request.series;
  file.volume = request.image;
  return file;
}

bool starts_from_models(const SegmentRequest& request) {
  if (!request.seed_organs.empty()) return true;
  return !request.models.empty() && request.seeds.empty() && request.radii.empty() && request.start_labels.empty() &&
         request.scene.empty();
}

namespace {

std::vector<std::string> place_organs(const SegmentRequest& request, const ModelFile& model, Scene& scene,
                                      const Volume& volume, const RunJobs& run) {
  const std::string file = "model " + quoted(fs::path(request.models.front()));
  const auto is_seeded = [&](const MeshItem& item) {
    return std::ranges::any_of(request.seed_organs, [&](const std::string& name) {
      return organ_of_name(model, name, file) == item.model->number;
    });
  };
  std::vector<FoundOrgan> found;
  std::vector<int> wanted;
  for (const MeshItem& item : scene.meshes) {
    if (!is_seeded(item)) {
      wanted.push_back(item.model->number);
      continue;
    }
    check_seed(item.seed, item.name, volume);
    const Mark seed{MarkKind::Inside, item.seed.centre_mm, item.seed.radius_mm};
    const ModelFit fit = ModelFitter(*item.model->organ, volume, run).fit({&seed, 1});
    if (trust_in(*item.model->organ, fit) == 0 && !std::ranges::all_of(scene.meshes, is_seeded))
      throw Error(file, "it does not recognise '" + item.model->organ->name + "' at its seed",
                  "correct centre and radius of the seed, or place a seed in each organ");
    found.push_back({item.model->number, fit.points});
  }
  const std::vector<FoundSeed> seeds = find_organs(model.organs, model.relations, volume, found, wanted, run);
  std::vector<std::string> warnings;
  std::erase_if(scene.meshes, [&](MeshItem& item) {
    if (is_seeded(item)) return false;
    const auto one = std::ranges::find(seeds, item.model->number, &FoundSeed::organ);
    if (one != seeds.end()) {
      item.seed = {one->seed.position_mm, one->seed.radius_mm};
      return false;
    }
    const std::string& name = item.model->organ->name;
    if (!request.organs.empty())
      throw Error(file, "it does not recognise '" + name + "' in this image",
                  "place a seed in the organ with --seed X,Y,Z, --radius and --seed-organ");
    warnings.push_back(file + ": it does not recognise '" + name + "' in this image");
    return true;
  });
  if (scene.meshes.empty())
    throw Error(file, "it does not recognise its organs in this image",
                "place a seed in one of them with --seed X,Y,Z, --radius and --seed-organ");
  return warnings;
}

}  // namespace

std::vector<std::string> place_seeds_by_models(const SegmentRequest& request, Scene& scene, const Volume& volume,
                                               const RunJobs& run) {
  if (const std::optional<ModelFile> several = model_of_several(request))
    return place_organs(request, *several, scene, volume, run);
  for (MeshItem& item : scene.meshes) {
    const std::optional<Mark> seed = find_organ(*item.model->organ, volume, run);
    if (!seed)
      throw Error("model " + quoted(fs::path(item.model->path)), "it does not recognise its organ in this image",
                  "place a seed in the organ with --seed X,Y,Z and --radius");
    item.seed = {seed->position_mm, seed->radius_mm};
  }
  return {};
}

}  // namespace simplexseg
