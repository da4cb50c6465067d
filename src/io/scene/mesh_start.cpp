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

}  // namespace

LoadedStart start_of_labels(const Volume& labels, const LabelChoice& choice, const std::string& path, int vertices) {
  Mask mask = choose_label(labels, choice, quoted(fs::path(path))).mask;
  fill_cavities(mask, kMaxFilledCavity);
  const InscribedBall ball = largest_inscribed_ball(mask);
  return {{path, choice.label, choice.part, std::make_shared<const SimplexMesh>(mesh_of_mask(mask, vertices))},
          {ball.centre_mm, ball.radius_mm},
          {}};
}

LoadedStart start_of_mesh(const fs::path& file, const std::string& path) {
  SimplexMesh mesh = read_mesh(file);
  const Seed seed = inscribed_ball(mesh, file);
  return {{path, std::nullopt, 0, std::make_shared<const SimplexMesh>(std::move(mesh))}, seed, {}};
}

LoadedStart load_start(const MeshStart& start, const fs::path& scene_folder, int vertices) {
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

MeshStart mesh_start_from_json(const JsonInput& input) {
  input.expect_keys(start_keys());
  MeshStart start{input[input.has("mesh") ? "mesh" : "labels"].text(), std::nullopt, 0, nullptr};
  if (input.has("label")) start.value = input["label"].number();
  if (input.has("part")) start.part = input["part"].integer_between(1, std::numeric_limits<int>::max());
  read_carried(input, start);
  return start;
}

}  // namespace simplexseg
