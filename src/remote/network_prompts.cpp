// SPDX-License-Identifier: Apache-2.0
#include "remote/network_prompts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <span>

#include "core/error.h"
#include "core/number_text.h"
#include "field/box_prompt.h"
#include "image/label_surface.h"

namespace simplexseg {
namespace {

std::optional<VoxelIndex> voxel_at(const Eigen::Vector3d& world_mm, const VolumeGeometry& geometry) {
  if (!world_mm.allFinite() || !geometry.contains(world_mm)) return std::nullopt;
  const Eigen::Vector3d index = geometry.index_from_world() * world_mm;
  VoxelIndex voxel;
  for (int a = 0; a < 3; ++a) voxel[a] = std::clamp(static_cast<int>(std::lround(index[a])), 0, geometry.size[a] - 1);
  return voxel;
}

std::size_t offset_of(const VoxelIndex& voxel, const VolumeGeometry& geometry) {
  const auto& size = geometry.size;
  return (static_cast<std::size_t>(voxel[2]) * size[1] + voxel[1]) * size[0] + voxel[0];
}

/// Voxels along a path, without gaps. Its points have a distance of at most half a voxel: a scribble may be thinner
/// than the slices that it crosses.
StrokeVoxels scribble_along(std::span<const Eigen::Vector3d> path_mm, int thickness, const VolumeGeometry& geometry) {
  const double voxel_mm = geometry.spacing_mm.minCoeff();
  PaintStroke stroke;
  stroke.radius_mm = thickness * voxel_mm / 2;
  for (const Mark& ball : marks_of_stroke(MarkKind::Inside, path_mm, voxel_mm / 2))
    stroke.vertices_mm.push_back(ball.position_mm);
  return voxels_of(stroke, geometry);
}

}  // namespace

NetworkPrompts prompts_of(const Scene& scene, const MeshItem& item, const VolumeGeometry& geometry,
                          int scribble_voxels) {
  NetworkPrompts prompts;
  const std::optional<VoxelIndex> seed = voxel_at(item.seed.centre_mm, geometry);
  if (!seed) throw Error("the seed of '" + item.name + "'", "it lies outside the image", "place it in the object");
  prompts.inside.push_back(*seed);
  std::set<VoxelIndex> sent{*seed};
  const auto add = [&](MarkKind kind, const std::vector<Eigen::Vector3d>& path) {
    if (scribble_voxels > 0 && path.size() > 1) {
      StrokeVoxels voxels = scribble_along(path, scribble_voxels, geometry);
      const bool any = std::ranges::any_of(voxels.voxels, [](VoxelPaint voxel) { return voxel != VoxelPaint::None; });
      if (any) prompts.scribbles.push_back({kind == MarkKind::Inside, std::move(voxels)});
      return;
    }
    const std::size_t count = std::min(path.size(), kPointsOfStroke);
    for (std::size_t n = 0; n < count; ++n) {
      const std::size_t at = count < 2 ? path.size() / 2 : n * (path.size() - 1) / (count - 1);
      const std::optional<VoxelIndex> voxel = voxel_at(path[at], geometry);
      if (voxel && sent.insert(*voxel).second)
        (kind == MarkKind::Inside ? prompts.inside : prompts.outside).push_back(*voxel);
    }
  };
  for (const UserPoint& point : scene.points) {
    if (point.mesh != item.id || point.is_paint() || point.kind == MarkKind::Boundary) continue;
    if (!point.is_lasso()) {
      add(point.kind, point.vertices_mm());
    } else if (point.strokes) {
      for (const PromptStroke& stroke : *point.strokes) add(stroke.kind, stroke.path_mm);
    }
  }
  return prompts;
}

std::string text_of(const NetworkPrompts& prompts) {
  std::string points = counted(static_cast<std::int64_t>(prompts.inside.size() + prompts.outside.size()), "point");
  if (prompts.scribbles.empty()) return points;
  return points + " and " + counted(static_cast<std::int64_t>(prompts.scribbles.size()), "scribble");
}

PaintVoxels object_at_prompts(Mask mask, const NetworkPrompts& prompts) {
  const char* const what = "the mask of the network";
  std::set<std::size_t> inside;
  for (const VoxelIndex& voxel : prompts.inside) inside.insert(offset_of(voxel, mask.geometry));
  for (const NetworkScribble& scribble : prompts.scribbles)
    if (scribble.inside)
      scribble.voxels.for_each([&](int i, int j, int k, bool) { inside.insert(offset_of({i, j, k}, mask.geometry)); });
  const std::vector<std::vector<std::size_t>> parts = connected_components(mask);
  if (parts.empty()) throw Error(what, "it is empty", "add an inside mark, or move the seed");
  Mask object{mask.geometry, std::vector<std::uint8_t>(mask.voxels.size())};
  for (const std::vector<std::size_t>& part : parts)
    if (std::ranges::any_of(part, [&](std::size_t voxel) { return inside.contains(voxel); }))
      for (const std::size_t voxel : part) object.voxels[voxel] = 1;
  if (!object.voxels[offset_of(prompts.inside.front(), mask.geometry)])
    throw Error(what, "it does not contain the seed", "add an inside mark, or move the seed");
  std::ranges::fill(mask.voxels, 0);
  PaintVoxels voxels = *difference_of(mask, object);
  if (voxels.voxels.size() > std::size_t{1} << 28)
    throw Error(what, "it is larger than 2^28 voxels", "use an image of a part");
  return voxels;
}

}  // namespace simplexseg
