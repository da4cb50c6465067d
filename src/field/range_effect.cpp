// SPDX-License-Identifier: Apache-2.0
#include "field/range_effect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "field/box_grid.h"
#include "field/box_image.h"

namespace simplexseg {
namespace {

constexpr std::array<std::string_view, 4> kNames{"limits", "all_voxels", "no_voxel", "without_seed"};

/// Whether any finite voxel lies in the range, and whether any lies outside. Stops when both are known.
std::array<bool, 2> has_voxels_in_and_out(const IntensityRange& range, const Volume& volume) {
  bool in = false, out = false;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    for (const T voxel : volume.voxels<T>()) {
      const auto value = static_cast<double>(voxel);
      if (!std::isfinite(value)) continue;
      (range.contains(value) ? in : out) = true;
      if (in && out) return;
    }
  });
  return {in, out};
}

/// Part of the cells of the seed that lie in the range.
double share_of_seed(const IntensityRange& range, const Volume& volume, const CellSize& cell, const Mark& seed,
                     double smoothing, const RunJobs& run) {
  constexpr int kMargin = 3;  // cells beside the ball that the smoothing uses
  const VolumeGeometry cells = cell_geometry(volume.geometry(), cell);
  const Eigen::Affine3d index = cells.index_from_world();
  const Eigen::Vector3d centre = index * seed.position_mm;
  VoxelBox box{};
  for (int a = 0; a < 3; ++a) {
    const double reach = seed.radius_mm * index.linear().row(a).norm() + kMargin;
    const double most = cells.size[a] - 1;
    box.first[a] = static_cast<int>(std::floor(std::clamp(centre[a] - reach, 0.0, most)));
    box.size[a] = static_cast<int>(std::ceil(std::clamp(centre[a] + reach, 0.0, most))) - box.first[a] + 1;
  }
  std::array<double, 3> spacing_mm;
  for (int a = 0; a < 3; ++a) spacing_mm[a] = cells.spacing_mm[a];
  const std::vector<std::uint8_t> in_range = cells_in_range(volume, cell, box, range, spacing_mm, smoothing, run);
  const Eigen::Affine3d world = cells.world_from_index();
  std::size_t all = 0, in = 0;
  double nearest_mm = INFINITY;
  bool nearest_in = true;  // for a ball between the centres of cells
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i) {
        const Eigen::Vector3d at = world * Eigen::Vector3d(box.first[0] + i, box.first[1] + j, box.first[2] + k);
        const double distance_mm = (at - seed.position_mm).norm();
        const bool is_in = in_range[box.offset(i, j, k)] != 0;
        if (distance_mm <= seed.radius_mm) ++all, in += is_in;
        if (distance_mm < nearest_mm) nearest_mm = distance_mm, nearest_in = is_in;
      }
  return all > 0 ? static_cast<double>(in) / static_cast<double>(all) : nearest_in ? 1 : 0;
}

}  // namespace

RangeEffect effect_of(const IntensityRange& range, const Volume& volume, const CellSize& cell, const Mark& seed,
                      double smoothing, const RunJobs& run) {
  if (!range.is_limited()) return RangeEffect::Limits;
  const auto [in, out] = has_voxels_in_and_out(range, volume);
  if (!in) return RangeEffect::NoVoxel;
  if (!out) return RangeEffect::AllVoxels;
  return share_of_seed(range, volume, cell, seed, smoothing, run) < 0.5 ? RangeEffect::WithoutSeed
                                                                        : RangeEffect::Limits;
}

std::string_view name_of(RangeEffect effect) { return kNames[static_cast<std::size_t>(effect)]; }

RangeEffect range_effect_of(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  return found == kNames.end() ? RangeEffect::Limits : static_cast<RangeEffect>(found - kNames.begin());
}

}  // namespace simplexseg
