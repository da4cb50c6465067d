// SPDX-License-Identifier: Apache-2.0
#include "remote/network_prompts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/error.h"
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

}  // namespace

NetworkPrompts prompts_of(const Scene& scene, const MeshItem& item, const VolumeGeometry& geometry) {
  NetworkPrompts prompts;
  const std::optional<VoxelIndex> seed = voxel_at(item.seed.centre_mm, geometry);
  if (!seed) throw Error("the seed of '" + item.name + "'", "it lies outside the image", "place it in the object");
  prompts.inside.push_back(*seed);
  std::set<VoxelIndex> sent{*seed};
  const auto add = [&](MarkKind kind, const std::vector<Eigen::Vector3d>& path) {
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

PaintVoxels object_at_prompts(Mask mask, const NetworkPrompts& prompts) {
  const char* const what = "the mask of the network";
  std::set<std::size_t> inside;
  for (const VoxelIndex& voxel : prompts.inside) inside.insert(offset_of(voxel, mask.geometry));
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
