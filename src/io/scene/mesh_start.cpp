// SPDX-License-Identifier: Apache-2.0
#include "io/scene/mesh_start.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "core/error.h"
#include "image/label_surface.h"
#include "image/rasterise.h"
#include "io/labels/labels_io.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/scene/json_input.h"
#include "io/scene/point_text.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

/// Largest cavity that is filled, voxels: a ball with a radius of two voxels. Smoothing would collapse the surface of
/// such a cavity, and the solver would undo its steps.
constexpr std::size_t kMaxFilledCavity = 33;

/// Approximate largest ball inside a closed surface, computed on a separate grid.
Seed inscribed_ball(const SimplexMesh& mesh, const fs::path& file) {
  constexpr int kVoxels = 64;  // along the longest side of the surface
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : mesh.positions) box.extend(p);
  const Eigen::Vector3d extent_mm = box.sizes().cast<double>();
  VolumeGeometry grid;
  const double spacing_mm = std::max(extent_mm.maxCoeff() / kVoxels, 1e-6);
  grid.spacing_mm.setConstant(spacing_mm);
  grid.origin_mm = box.min().cast<double>().array() - spacing_mm / 2;
  for (int axis = 0; axis < 3; ++axis) grid.size[axis] = static_cast<int>(extent_mm[axis] / spacing_mm) + 3;
  const Mask mask = rasterise(mesh, grid);
  if (std::find(mask.voxels.begin(), mask.voxels.end(), 1) == mask.voxels.end())
    throw Error("cannot make a mesh from " + quoted(file), "its surface encloses no volume", "use a closed surface");
  const InscribedBall ball = largest_inscribed_ball(mask);
  return {ball.centre_mm, ball.radius_mm};
}

/// Start without its origin.
LoadedStart start_of_mask(Mask mask, int vertices) {
  fill_cavities(mask, kMaxFilledCavity);
  const InscribedBall ball = largest_inscribed_ball(mask);
  LoadedStart loaded;
  loaded.start.mesh = std::make_shared<const SimplexMesh>(mesh_of_mask(mask, vertices));
  loaded.seed = {ball.centre_mm, ball.radius_mm};
  return loaded;
}

}  // namespace

LoadedStart start_of_labels(const Volume& labels, const LabelChoice& choice, const std::string& path, int vertices) {
  LoadedStart loaded = start_of_mask(choose_label(labels, choice, quoted(fs::path(path))).mask, vertices);
  loaded.start.path = path, loaded.start.value = choice.label, loaded.start.part = choice.part;
  return loaded;
}

LoadedStart start_of_network(std::shared_ptr<const NetworkMask> mask, double error_mm, int vertices) {
  Mask voxels{mask->voxels.box, {}};
  for (const VoxelPaint voxel : mask->voxels.voxels) voxels.voxels.push_back(voxel == VoxelPaint::Inside);
  if (std::ranges::find(voxels.voxels, 1) == voxels.voxels.end())
    throw Error("the mask of a network", "it is empty", "add a mark inside the object, or another seed");
  LoadedStart loaded = start_of_mask(std::move(voxels), vertices);
  loaded.start.network = std::move(mask), loaded.start.error_mm = error_mm;
  return loaded;
}

LoadedStart start_of_mesh(const fs::path& file, const std::string& path) {
  SimplexMesh mesh = read_mesh(file);
  const Seed seed = inscribed_ball(mesh, file);
  return {{path, std::nullopt, 0, std::make_shared<const SimplexMesh>(std::move(mesh))}, seed, {}};
}

LoadedStart load_start(const MeshStart& start, const fs::path& scene_folder, int vertices) {
  if (start.network) return start_of_network(start.network, start.error_mm, vertices);
  const fs::path file = find_data(start.path, scene_folder);
  if (is_mesh_name(file)) {
    LoadedStart loaded = start_of_mesh(file, start.path);
    loaded.start.error_mm = start.error_mm, loaded.start.earlier = start.earlier;
    return loaded;
  }
  const LabelChoice choice{start.value, start.part};
  LoadedLabels labels = load_labels(file, choice);
  LoadedStart loaded = start_of_labels(labels.volume, choice, start.path, vertices);
  loaded.start.error_mm = start.error_mm, loaded.start.earlier = start.earlier;
  loaded.warnings = std::move(labels.warnings);
  return loaded;
}

void read_carried(const JsonInput& input, MeshStart& start) {
  if (input.has("error_mm")) {
    start.error_mm = input["error_mm"].number();
    if (!(start.error_mm > 0 && start.error_mm <= kMaxErrorMm))
      input["error_mm"].fail("it is out of range", "use a deviation above 0 and up to 100 mm");
  }
  if (!input.has("earlier")) return;
  const JsonInput earlier = input["earlier"];
  earlier.expect_keys({"volume_ml", "long_mm", "short_mm", "centroid_mm"});
  for (const auto& [key, value] :
       {std::pair("volume_ml", &start.earlier.volume_ml), std::pair("long_mm", &start.earlier.long_mm),
        std::pair("short_mm", &start.earlier.short_mm)}) {
    *value = earlier[key].number();
    if (!(*value >= 0)) earlier[key].fail("it is below 0", "correct it");
  }
  if (!(start.earlier.volume_ml > 0)) earlier["volume_ml"].fail("it is not above 0", "correct it");
  start.earlier.centroid_mm = earlier["centroid_mm"].vector3();
}

std::shared_ptr<const NetworkMask> read_network(const JsonInput& input) {
  input.expect_keys({"server", "name", "licence", "voxels"});
  auto mask = std::make_shared<NetworkMask>();
  mask->server = input["server"].text();
  if (input.has("name")) mask->network = input["name"].text();
  if (input.has("licence")) mask->licence = input["licence"].text();
  mask->voxels = *read_voxels(input["voxels"]);
  mask->identity = identity_of(mask->voxels);
  return mask;
}

void read_set_start(const JsonInput& input, SetStart& command) {
  input.expect_keys({"mesh", "start", "after_steps", "command"});
  command.mesh = static_cast<ItemId>(input["mesh"].integer_between(0, std::numeric_limits<int>::max()));
  if (input.has("start")) command.start = mesh_start_from_json(input["start"]);
}

void load_start_of(Command& command) {
  const auto load = [](std::optional<MeshStart>& start) {
    if (start) start = load_start(*start, {}).start;
  };
  if (auto* const add = std::get_if<AddMesh>(&command)) load(add->start);
  if (auto* const set = std::get_if<SetStart>(&command)) load(set->start);
}

MeshStart mesh_start_from_json(const JsonInput& input) {
  input.expect_keys(start_keys());
  if (input.has("network")) {
    for (const std::string& key : start_keys())
      if (key != "network" && key != "error_mm" && input.has(key))
        input[key].fail("the start is the mask of a network", "delete one of the two");
    MeshStart start;
    start.network = read_network(input["network"]);
    if (!input.has("error_mm")) input.fail("the error of the mask is missing", "add error_mm, above 0");
    read_carried(input, start);
    return start;
  }
  MeshStart start{input[input.has("mesh") ? "mesh" : "labels"].text(), std::nullopt, 0, nullptr};
  if (input.has("label")) start.value = input["label"].number();
  if (input.has("part")) start.part = input["part"].integer_between(1, std::numeric_limits<int>::max());
  read_carried(input, start);
  return start;
}

}  // namespace simplexseg
