// SPDX-License-Identifier: Apache-2.0
#include "image/resample.h"

namespace simplexseg {
namespace {

/// Calls f(offset in `from`, offset in `to`) for each voxel of `from` whose centre lies in a voxel of `to`.
template <class F>
void each_pair(const VolumeGeometry& from, const VolumeGeometry& to, F&& f) {
  const Eigen::Affine3d to_from = to.index_from_world() * from.world_from_index();
  const Eigen::Vector3d step = to_from.linear().col(0);
  std::size_t offset = 0;
  for (int k = 0; k < from.size[2]; ++k) {
    for (int j = 0; j < from.size[1]; ++j) {
      const Eigen::Vector3d row = to_from * Eigen::Vector3d(0, j, k);
      for (int i = 0; i < from.size[0]; ++i, ++offset) {
        const Eigen::Array3d index = (row + i * step).array() + 0.5;  // ties round up on every grid
        if (!(index[0] >= 0 && index[1] >= 0 && index[2] >= 0 && index[0] < to.size[0] && index[1] < to.size[1] &&
              index[2] < to.size[2]))
          continue;
        const auto at = [&](int axis) { return static_cast<std::size_t>(index[axis]); };
        f(offset,
          (at(2) * static_cast<std::size_t>(to.size[1]) + at(1)) * static_cast<std::size_t>(to.size[0]) + at(0));
      }
    }
  }
}

}  // namespace

ResampledLabels resample_labels(const Volume& labels, const VolumeGeometry& grid) {
  ResampledLabels result{.labels = Volume(grid, labels.type())};
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    const auto from = labels.voxels<T>();
    const auto to = result.labels.voxels<T>();
    each_pair(grid, labels.geometry(), [&](std::size_t voxel, std::size_t source) { to[voxel] = from[source]; });
    for (const T value : from) result.labelled += value != T(0) && value == value;  // NaN is background
    std::size_t inside = 0;
    each_pair(labels.geometry(), grid,
              [&](std::size_t voxel, std::size_t) { inside += from[voxel] != T(0) && from[voxel] == from[voxel]; });
    result.outside = result.labelled - inside;
  });
  return result;
}

}  // namespace simplexseg
