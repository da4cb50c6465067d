// SPDX-License-Identifier: Apache-2.0
#include "image/mask.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"
#include "image/voxel_rows.h"

namespace simplexseg {

VoxelBox bounding_box(const Mask& a, const Mask& b) {
  SIMPLEXSEG_EXPECT(a.geometry.size == b.geometry.size);
  SIMPLEXSEG_EXPECT(a.voxels.size() == a.geometry.voxel_count() && b.voxels.size() == a.voxels.size());
  const auto [ni, nj, nk] = a.geometry.size;
  std::array<int, 3> low{ni, nj, nk}, high{-1, -1, -1};
  const std::uint8_t *row_a = a.voxels.data(), *row_b = b.voxels.data();
  for (int k = 0; k < nk; ++k) {
    for (int j = 0; j < nj; ++j, row_a += ni, row_b += ni) {
      int first = 0, last = ni - 1;
      while (first < ni && !(row_a[first] | row_b[first])) ++first;
      if (first == ni) continue;
      while (!(row_a[last] | row_b[last])) --last;
      low = {std::min(low[0], first), std::min(low[1], j), std::min(low[2], k)};
      high = {std::max(high[0], last), std::max(high[1], j), k};
    }
  }
  if (high[2] < 0) return {};
  return {low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1}};
}

Mask mask_of(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> voxels) {
  SIMPLEXSEG_EXPECT(voxels.size() == box.voxel_count());
  Mask mask{geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
  copy_into_outer(voxels.data(), box, mask.voxels.data(), VoxelBox{{0, 0, 0}, geometry.size});
  return mask;
}

Mask mask_of(const Volume& labels, std::optional<double> label) {
  Mask mask{labels.geometry(), std::vector<std::uint8_t>(labels.empty() ? 0 : labels.geometry().voxel_count())};
  if (labels.empty()) return mask;
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = labels.voxels<T>();
    if (!label) {
      // The second comparison excludes NaN, which some programs write as background.
      for (std::size_t v = 0; v < voxels.size(); ++v) mask.voxels[v] = voxels[v] != T(0) && voxels[v] == voxels[v];
    } else if (*label >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
               *label <= static_cast<double>(std::numeric_limits<T>::max()) &&
               static_cast<double>(static_cast<T>(*label)) == *label) {
      const T value = static_cast<T>(*label);
      for (std::size_t v = 0; v < voxels.size(); ++v) mask.voxels[v] = voxels[v] == value;
    }
  });
  return mask;
}

}  // namespace simplexseg
