// SPDX-License-Identifier: Apache-2.0
#include "image/surface_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/expect.h"
#include "image/mask.h"

namespace simplexseg {
namespace {

/// Bounding box of the mask, enlarged on each side by a quarter of its size and two voxels of background.
VoxelBox padded_box(const Mask& mask) {
  VoxelBox box = bounding_box(mask, mask);
  if (box.voxel_count() == 0) return box;
  for (int a = 0; a < 3; ++a) {
    const int margin = box.size[a] / 4 + 2;
    box.first[a] -= margin;
    box.size[a] += 2 * margin;
  }
  return box;
}

}  // namespace

SurfaceError::SurfaceError(const Mask& reference) : box_(padded_box(reference)) {
  const VolumeGeometry& g = reference.geometry;
  SIMPLEXSEG_EXPECT(reference.voxels.size() == g.voxel_count());
  world_from_index_ = g.world_from_index() * Eigen::Translation3d(box_.first[0], box_.first[1], box_.first[2]);
  index_from_world_ = world_from_index_.inverse();
  if (box_.voxel_count() == 0) return;
  const auto [ni, nj, nk] = box_.size;
  std::vector<std::uint8_t> inside(box_.voxel_count()), outside(box_.voxel_count(), 1);
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const int gi = i + box_.first[0], gj = j + box_.first[1], gk = k + box_.first[2];
        if (gi < 0 || gj < 0 || gk < 0 || gi >= g.size[0] || gj >= g.size[1] || gk >= g.size[2]) continue;
        const std::size_t v = (static_cast<std::size_t>(gk) * g.size[1] + gj) * g.size[0] + gi;
        if (!reference.voxels[v]) continue;
        inside[box_.offset(i, j, k)] = 1;
        outside[box_.offset(i, j, k)] = 0;
      }
  const Eigen::Matrix3d mm_from_index = world_from_index_.linear();
  signed_mm_ = distance_map(inside, box_, mm_from_index);
  const std::vector<float> depth = distance_map(outside, box_, mm_from_index);
  for (std::size_t v = 0; v < depth.size(); ++v) signed_mm_[v] -= depth[v];
  // So far, signed_mm_ has the distances to the nearest voxel centre on the other side of the surface. Subtracts the
  // distance from that centre to the surface, which is half the extent of a voxel along the gradient.
  const Eigen::Matrix3d to_mm = mm_from_index.inverse().transpose();
  std::vector<float> corrected(signed_mm_.size());
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const auto value = [&, ni = ni, nj = nj, nk = nk](int di, int dj, int dk) {
          return signed_mm_[box_.offset(std::clamp(i + di, 0, ni - 1), std::clamp(j + dj, 0, nj - 1),
                                        std::clamp(k + dk, 0, nk - 1))];
        };
        const Eigen::Vector3d slope(value(1, 0, 0) - value(-1, 0, 0), value(0, 1, 0) - value(0, -1, 0),
                                    value(0, 0, 1) - value(0, 0, -1));
        const Eigen::Vector3d gradient = to_mm * slope;
        const Eigen::Vector3d spacing_mm = mm_from_index.colwise().norm();
        const double length = gradient.norm();
        const double half =
            length > 0 ? 0.5 * (mm_from_index.transpose() * (gradient / length)).norm() : 0.5 * spacing_mm.minCoeff();
        const float d = signed_mm_[box_.offset(i, j, k)];
        corrected[box_.offset(i, j, k)] =
            d < 0 ? std::min(0.0f, d + static_cast<float>(half)) : std::max(0.0f, d - static_cast<float>(half));
      }
  signed_mm_ = std::move(corrected);
}

double SurfaceError::at(const Eigen::Vector3d& position_mm) const {
  if (signed_mm_.empty() || !position_mm.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d index = index_from_world_ * position_mm;
  Eigen::Vector3d nearest;
  int low[3];
  for (int a = 0; a < 3; ++a) {
    nearest[a] = std::clamp(index[a], 0.0, box_.size[a] - 1.0);
    low[a] = std::min(static_cast<int>(nearest[a]), box_.size[a] - 2);  // a box is at least 5 voxels wide
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    int at[3];
    for (int a = 0; a < 3; ++a) {
      const int up = corner >> a & 1;
      const double share = nearest[a] - low[a];
      weight *= up ? share : 1 - share;
      at[a] = low[a] + up;
    }
    sum += weight * signed_mm_[box_.offset(at[0], at[1], at[2])];
  }
  return std::abs(sum) + (world_from_index_.linear() * (index - nearest)).norm();
}

SurfaceError::Values SurfaceError::of(std::span<const Eigen::Vector3f> positions_mm) const {
  if (positions_mm.empty()) return {0, 0, 0};
  std::vector<double> distances;
  distances.reserve(positions_mm.size());
  for (const Eigen::Vector3f& p : positions_mm) distances.push_back(at(p.cast<double>()));
  const DistanceSummary summary = summarise(distances);
  return {summary.mean, summary.percentile95, summary.max};
}

}  // namespace simplexseg
