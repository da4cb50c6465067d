// SPDX-License-Identifier: Apache-2.0
#include "io/mesh_start.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "core/error.h"
#include "image/label_surface.h"
#include "image/rasterise.h"
#include "io/data_path.h"
#include "io/files.h"
#include "io/json_input.h"
#include "io/labels_io.h"
#include "io/mesh_io.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

/// Voxels of a ball of two voxels' radius. The surface of such a cavity shrinks to nothing under smoothing, and its
/// steps are undone.
constexpr std::size_t kSmallCavity = 33;

/// The largest ball (nearly) within a closed surface, found on a grid of its own.
Seed ball_within(const SimplexMesh& mesh, const fs::path& file) {
  constexpr int kVoxels = 64;  // along the longest side
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
    throw Error("cannot make a mesh of " + quoted(file), "its surface holds nothing", "give a closed surface");
  const InnerBall ball = inner_ball(mask);
  return {ball.centre_mm, ball.radius_mm};
}

}  // namespace

LoadedStart start_of_labels(const Volume& labels, const LabelChoice& choice, const std::string& path, int vertices) {
  Mask mask = choose_label(labels, choice, quoted(fs::path(path))).mask;
  fill_cavities(mask, kSmallCavity);
  const InnerBall ball = inner_ball(mask);
  return {{path, choice.label, choice.part, std::make_shared<const SimplexMesh>(mesh_of_mask(mask, vertices))},
          {ball.centre_mm, ball.radius_mm},
          {}};
}

LoadedStart start_of_mesh(const fs::path& file, const std::string& path) {
  SimplexMesh mesh = read_mesh(file);
  const Seed seed = ball_within(mesh, file);
  return {{path, std::nullopt, 0, std::make_shared<const SimplexMesh>(std::move(mesh))}, seed, {}};
}

LoadedStart load_start(const MeshStart& wanted, const fs::path& beside, int vertices) {
  const fs::path file = find_data(wanted.path, beside);
  if (is_mesh_name(file)) return start_of_mesh(file, wanted.path);
  const LabelChoice choice{wanted.value, wanted.part};
  LoadedLabels labels = load_labels(file, choice);
  LoadedStart loaded = start_of_labels(labels.volume, choice, wanted.path, vertices);
  loaded.warnings = std::move(labels.warnings);
  return loaded;
}

MeshStart read_named_start(const JsonInput& input) {
  input.expect_keys({"labels", "label", "part", "mesh"});
  MeshStart start{input[input.has("mesh") ? "mesh" : "labels"].text(), std::nullopt, 0, nullptr};
  if (input.has("label")) start.value = input["label"].number();
  if (input.has("part")) start.part = input["part"].integer_between(1, std::numeric_limits<int>::max());
  return start;
}

}  // namespace simplexseg
