// SPDX-License-Identifier: Apache-2.0
#include "image/plane_samples.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/expect.h"
#include "core/thread_pool.h"

namespace simplexseg {
namespace {

/// Trilinear interpolation between the voxels of an image by index.
template <class T>
class VoxelSampler {
 public:
  explicit VoxelSampler(const Volume& image)
      : voxels_(image.voxels<T>().data()),
        size_(image.geometry().size),
        row_(static_cast<std::size_t>(size_[0])),
        slice_(row_ * static_cast<std::size_t>(size_[1])) {}

  PlaneSample at(const Eigen::Vector3d& index) const {
    std::size_t offset[3];  // of the lower neighbour
    std::size_t step[3];    // to the upper neighbour
    float part[3];
    const std::size_t strides[3] = {1, row_, slice_};
    for (int a = 0; a < 3; ++a) {
      const int last = size_[static_cast<std::size_t>(a)] - 1;
      if (!(index[a] >= -0.5 && index[a] < last + 0.5)) return {};
      const double inside = std::clamp(index[a], 0.0, static_cast<double>(last));
      const int low = std::min(static_cast<int>(inside), std::max(0, last - 1));
      part[a] = static_cast<float>(inside - low);
      offset[a] = static_cast<std::size_t>(low) * strides[a];
      step[a] = last > 0 ? strides[a] : 0;
    }
    const T* const corner = voxels_ + offset[0] + offset[1] + offset[2];
    const auto along_i = [&](const T* v) {
      const auto first = static_cast<float>(v[0]);
      return first + part[0] * (static_cast<float>(v[step[0]]) - first);
    };
    const auto along_j = [&](const T* v) {
      const float first = along_i(v);
      return first + part[1] * (along_i(v + step[1]) - first);
    };
    const float first = along_j(corner), value = first + part[2] * (along_j(corner + step[2]) - first);
    return std::isfinite(value) ? PlaneSample{value, 1} : PlaneSample{};
  }

 private:
  const T* voxels_;
  std::array<int, 3> size_;
  std::size_t row_, slice_;
};

}  // namespace

void sample_plane(const Volume& image, const Transform& transform, const PlaneGrid& grid,
                  std::span<PlaneSample> samples, ThreadPool& pool) {
  SIMPLEXSEG_EXPECT(!image.empty() && samples.size() == static_cast<std::size_t>(grid.width) * grid.height);
  const Eigen::Affine3d index_from_world = image.geometry().index_from_world();
  const std::optional<Eigen::Affine3d> affine = transform.affine();
  visit_voxel_type(image.type(), [&]<class T>(std::type_identity<T>) {
    const VoxelSampler<T> sampler(image);
    pool.run(grid.height, [&](int v) {
      PlaneSample* const row = samples.data() + static_cast<std::size_t>(v) * grid.width;
      const Eigen::Vector3d first_mm = grid.origin_mm + v * grid.step_v_mm;
      if (affine) {
        const Eigen::Affine3d index_from_plane = index_from_world * *affine;
        const Eigen::Vector3d first = index_from_plane * first_mm, step = index_from_plane.linear() * grid.step_u_mm;
        for (int u = 0; u < grid.width; ++u) row[u] = sampler.at(first + u * step);
      } else {
        for (int u = 0; u < grid.width; ++u)
          row[u] = sampler.at(index_from_world * transform(first_mm + u * grid.step_u_mm));
      }
    });
  });
}

}  // namespace simplexseg
