// SPDX-License-Identifier: Apache-2.0
#include "image/intensity_samples.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/quantile.h"

namespace simplexseg {

std::size_t IntensityHistogram::interval_of(double intensity) const {
  const auto last = static_cast<double>(counts.size() - 1);
  const double share = (intensity - range.low) / (range.high - range.low);
  return static_cast<std::size_t>(std::clamp(share * static_cast<double>(counts.size()), 0.0, last));
}

IntensityRange range_of_rectangle(const Volume& volume, const std::array<Eigen::Vector3d, 3>& corners_mm) {
  const VolumeGeometry& geometry = volume.geometry();
  const Eigen::Affine3d index = geometry.index_from_world();
  const Eigen::Vector3d across = corners_mm[0] - corners_mm[1], down = corners_mm[2] - corners_mm[1];
  constexpr double kMostSteps = 2000;  // along a side: no more than the voxels of a large image
  const auto steps_along = [&](const Eigen::Vector3d& side) {
    return static_cast<int>(std::min(kMostSteps, std::ceil(2 * side.norm() / geometry.spacing_mm.minCoeff()))) + 1;
  };
  const int columns = steps_along(across), rows = steps_along(down);
  std::vector<std::size_t> voxels;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d at =
          index * (corners_mm[1] + across * column / std::max(1, columns - 1) + down * row / std::max(1, rows - 1));
      const std::array<long, 3> voxel{std::lround(at[0]), std::lround(at[1]), std::lround(at[2])};
      bool inside = true;
      for (int a = 0; a < 3; ++a) inside &= voxel[a] >= 0 && voxel[a] < geometry.size[a];
      if (inside)
        voxels.push_back(
            volume.offset(static_cast<int>(voxel[0]), static_cast<int>(voxel[1]), static_cast<int>(voxel[2])));
    }
  std::ranges::sort(voxels);
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  std::vector<float> values;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> all = volume.voxels<T>();
    for (const std::size_t voxel : voxels)
      if (const auto value = static_cast<float>(all[voxel]); std::isfinite(value)) values.push_back(value);
  });
  constexpr std::size_t kLeastVoxels = 9;
  if (values.size() < kLeastVoxels)
    throw Error("the range of intensities", "the rectangle contains fewer than nine voxels of the image",
                "drag a larger one over the tissue");
  const IntensityRange range{quantile(values, 0.01), quantile(values, 0.99)};
  if (!(range.low < range.high))
    throw Error("the range of intensities", "all voxels of the rectangle have the same intensity",
                "drag a larger one, or enter the limits");
  return range;
}

IntensityHistogram histogram_of(const Volume& volume, int intervals) {
  constexpr std::size_t kMostVoxels = 1'000'000;
  std::vector<float> values;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> all = volume.voxels<T>();
    const std::size_t step = all.size() / kMostVoxels + 1;
    values.reserve(all.size() / step + 1);
    for (std::size_t v = 0; v < all.size(); v += step)
      if (const auto value = static_cast<float>(all[v]); std::isfinite(value)) values.push_back(value);
  });
  if (values.empty()) return {};
  IntensityHistogram histogram;
  histogram.range = {quantile(values, 0.001), quantile(values, 0.999)};
  if (!(histogram.range.low < histogram.range.high)) histogram.range.high = histogram.range.low + 1;
  histogram.counts.assign(intervals, 0);
  for (const float value : values) ++histogram.counts[histogram.interval_of(value)];
  return histogram;
}

}  // namespace simplexseg
