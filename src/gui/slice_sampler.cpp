// SPDX-License-Identifier: Apache-2.0
#include "gui/slice_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace simplexseg {
namespace {

constexpr double kOnCentre = 1e-3;  // voxels: nearer than this to a voxel centre is on it
constexpr float kOutside = std::numeric_limits<float>::quiet_NaN();

// Voxel positions along one row of texels: start + n * step, in voxels.
struct Row {
  Eigen::Vector3d start, step;
  int count;
};

// The axis along which the row meets every voxel centre, -1 when it does not.
int on_centres_along(const Row& row) {
  int along = -1;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(row.start[axis] - std::round(row.start[axis])) > kOnCentre) return -1;
    const double drift = row.count;
    if (std::abs(std::abs(row.step[axis]) - 1) * drift < kOnCentre) {
      if (along >= 0) return -1;
      along = axis;
    } else if (std::abs(row.step[axis]) * drift > kOnCentre) {
      return -1;
    }
  }
  return along;
}

template <class T>
void copy_row(const Volume& volume, const Row& row, int along, float* out) {
  const auto& size = volume.geometry().size;
  const Eigen::Vector3i first = row.start.array().round().cast<int>();
  std::fill_n(out, row.count, kOutside);
  for (int axis = 0; axis < 3; ++axis) {
    if (axis != along && (first[axis] < 0 || first[axis] >= size[axis])) return;
  }
  const std::ptrdiff_t strides[3] = {1, size[0], static_cast<std::ptrdiff_t>(size[0]) * size[1]};
  const T* voxels = static_cast<const T*>(volume.data());
  std::ptrdiff_t base = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis != along) base += first[axis] * strides[axis];
  }
  const int direction = row.step[along] > 0 ? 1 : -1;
  for (int n = 0, i = first[along]; n < row.count; ++n, i += direction) {
    if (i >= 0 && i < size[along]) out[n] = static_cast<float>(voxels[base + i * strides[along]]);
  }
}

template <class T>
void interpolate_row(const Volume& volume, const Row& row, float* out) {
  const auto& size = volume.geometry().size;
  const std::ptrdiff_t row_stride = size[0], slice_stride = static_cast<std::ptrdiff_t>(size[0]) * size[1];
  const T* voxels = static_cast<const T*>(volume.data());
  const Eigen::Vector3f start = row.start.cast<float>(), step = row.step.cast<float>();
  const float high[3] = {size[0] - 0.5f, size[1] - 0.5f, size[2] - 0.5f};
  constexpr float kSlack = 1e-3f;
  for (int n = 0; n < row.count; ++n) {
    int low[3], next[3];
    float fraction[3];
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      const float index = start[axis] + static_cast<float>(n) * step[axis];
      inside &= index >= -0.5f - kSlack && index <= high[axis] + kSlack;
      const float clamped = std::clamp(index, 0.0f, static_cast<float>(size[axis] - 1));
      low[axis] = static_cast<int>(clamped);
      next[axis] = low[axis] + (low[axis] + 1 < size[axis]);
      fraction[axis] = clamped - static_cast<float>(low[axis]);
    }
    if (!inside) {
      out[n] = kOutside;
      continue;
    }
    const auto at = [&](int i, int j, int k) {
      return static_cast<float>(voxels[i + j * row_stride + k * slice_stride]);
    };
    const auto along_i = [&](int j, int k) {
      const float a = at(low[0], j, k);
      return a + fraction[0] * (at(next[0], j, k) - a);
    };
    const auto along_j = [&](int k) {
      const float a = along_i(low[1], k);
      return a + fraction[1] * (along_i(next[1], k) - a);
    };
    const float a = along_j(low[2]);
    out[n] = a + fraction[2] * (along_j(next[2]) - a);
  }
}

}  // namespace

void sample_slice(const Volume& volume, const SliceGrid& grid, std::vector<float>& intensities) {
  intensities.resize(static_cast<std::size_t>(grid.width) * grid.height);
  const Eigen::Affine3d index_from_world = volume.geometry().index_from_world();
  const Eigen::Vector3d origin = index_from_world * grid.origin_mm;
  const Eigen::Vector3d step_u = index_from_world.linear() * grid.step_u_mm;
  const Eigen::Vector3d step_v = index_from_world.linear() * grid.step_v_mm;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    for (int v = 0; v < grid.height; ++v) {
      const Row row{origin + v * step_v, step_u, grid.width};
      float* out = intensities.data() + static_cast<std::size_t>(v) * grid.width;
      const int along = on_centres_along(row);
      if (along >= 0) {
        copy_row<T>(volume, row, along, out);
      } else {
        interpolate_row<T>(volume, row, out);
      }
    }
  });
}

void SliceImages::set_volume(const Volume& volume) {
  volume_ = volume;
  for (SliceImage& image : images_) image = SliceImage{{}, {}, 0};
}

const SliceImage& SliceImages::image(Orientation orientation, const Eigen::Vector3d& through_mm) {
  const int which = static_cast<int>(orientation);
  SliceImage& image = images_[which];
  const double position = through_mm[slice_axes(orientation, Convention::Radiological).normal];
  if (volume_.empty() || (image.stamp != 0 && position_mm_[which] == position)) return image;
  position_mm_[which] = position;
  image.grid = slice_grid(volume_.geometry(), orientation, through_mm);
  sample_slice(volume_, image.grid, image.intensities);
  image.stamp = next_stamp_++;
  return image;
}

}  // namespace simplexseg
