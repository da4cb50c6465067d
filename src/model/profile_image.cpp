// SPDX-License-Identifier: Apache-2.0
#include "model/profile_image.h"

#include <algorithm>
#include <cmath>

#include "core/quantile.h"
#include "field/box_image.h"

namespace simplexseg {
namespace {

constexpr double kSmoothingCells = 1;  ///< standard deviation of the Gaussian
constexpr double kLeastCell = 1.3;     ///< least cell other than a voxel, voxels
constexpr double kHounsfieldUnit = 500;

/// Box of voxels within a distance of a place along all axes, in the volume; at least one voxel.
VoxelBox box_within(const VolumeGeometry& volume, const Eigen::Vector3d& centre_mm, double radius_mm) {
  const Eigen::Affine3d index = volume.index_from_world();
  const Eigen::Vector3d at = index * centre_mm;
  VoxelBox box{};
  for (int a = 0; a < 3; ++a) {
    const double half = radius_mm * index.linear().row(a).norm();
    const int last = volume.size[a] - 1;
    const int low = std::clamp(static_cast<int>(std::floor(at[a] - half)), 0, last);
    const int high = std::clamp(static_cast<int>(std::ceil(at[a] + half)), low, last);
    box.first[a] = low, box.size[a] = high - low + 1;
  }
  return box;
}

}  // namespace

ProfileImage::ProfileImage(const Volume& volume, const Eigen::Vector3d& centre_mm, double radius_mm,
                           const ProfileModel& model, const RunJobs& run)
    : volume_(volume.geometry()) {
  CellSize cell = kVoxelCells;
  for (int a = 0; a < 3; ++a) {
    const double voxels = std::max(model.step_mm, model.cell_mm) / volume_.spacing_mm[a];
    if (voxels >= kLeastCell) cell[a] = voxels;
  }
  const VolumeGeometry cells = cell_geometry(volume_, cell);
  const VoxelBox box = cells_around(box_within(volume_, centre_mm, radius_mm), cell, volume_.size);
  BoxImage image = extract_intensities(volume, cell, box, run);
  grid_ = image.grid;
  unit_ = kHounsfieldUnit;
  if (model.scale == IntensityScale::Percentiles) {
    const VoxelBox near = cells_around(box_within(volume_, centre_mm, model.surroundings_mm), cell, volume_.size);
    std::vector<float> sample;
    for (int k = 0; k < near.size[2]; ++k)
      for (int j = 0; j < near.size[1]; ++j)
        for (int i = 0; i < near.size[0]; ++i) {
          const std::array index{near.first[0] + i - box.first[0], near.first[1] + j - box.first[1],
                                 near.first[2] + k - box.first[2]};
          bool in_box = true;
          for (int a = 0; a < 3; ++a) in_box = in_box && index[a] >= 0 && index[a] < box.size[a];
          if (!in_box) continue;
          const std::size_t v = box.offset(index[0], index[1], index[2]);
          if (image.finite[v]) sample.push_back(image.value[v]);
        }
    float high = 1;
    if (!sample.empty()) low_ = quantile(sample, 0.02), high = quantile(sample, 0.98);
    unit_ = high > low_ ? high - low_ : 1;
  }
  values_ = std::move(image.value);
  for (std::size_t v = 0; v < values_.size(); ++v) values_[v] = image.finite[v] ? (values_[v] - low_) / unit_ : 0;
  const std::array spacing{cells.spacing_mm[0], cells.spacing_mm[1], cells.spacing_mm[2]};
  smooth_by_least_spacing(values_, grid_, spacing, kSmoothingCells, run);
  index_from_world_ = Eigen::Translation3d(-box.first[0], -box.first[1], -box.first[2]) * cells.index_from_world();
  cell_mm_ = cells.spacing_mm.minCoeff();
}

float ProfileImage::sample(const Eigen::Vector3d& mm) const {
  const Eigen::Vector3d at = index_from_world_ * mm;
  std::array<int, 3> low, step;
  std::array<float, 3> share;
  for (int a = 0; a < 3; ++a) {
    const double x = std::clamp(at[a], 0.0, grid_.size[a] - 1.0);
    low[a] = static_cast<int>(x);
    share[a] = static_cast<float>(x - low[a]);
    step[a] = low[a] + 1 < grid_.size[a] ? grid_.stride(a) : 0;
  }
  const float* const p =
      values_.data() + low[0] + std::ptrdiff_t(low[1]) * grid_.row() + std::ptrdiff_t(low[2]) * grid_.plane();
  const auto along = [&](const float* q) { return q[0] + share[0] * (q[step[0]] - q[0]); };
  const auto plane = [&](const float* q) {
    const float a = along(q);
    return a + share[1] * (along(q + step[1]) - a);
  };
  const float a = plane(p);
  return a + share[2] * (plane(p + step[2]) - a);
}

}  // namespace simplexseg
