// SPDX-License-Identifier: Apache-2.0
#include "field/slice_region.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "image/distance_map.h"

namespace simplexseg {
namespace {

constexpr double kLeastDepth = 0.5;  // of the depth of a voxel on the path, relative to the largest in the slice

}  // namespace

SliceRegion::SliceRegion(const VolumeGeometry& grid, const std::array<int, 3>& start_voxel, int axis,
                         const std::function<bool(std::size_t)>& is_set)
    : grid_(grid) {
  a_ = axis == 0 ? 1 : 0, b_ = axis == 2 ? 1 : 2;
  fixed_ = start_voxel;
  std::vector<std::uint8_t> seen(count());
  std::vector<std::size_t> found{start()};
  seen[start()] = 1;
  for (std::size_t n = 0; n < found.size(); ++n) {
    const int a = static_cast<int>(found[n]) % size_a(), b = static_cast<int>(found[n]) / size_a();
    for (const auto& [da, db] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      if (!contains(a + da, b + db)) continue;
      const std::size_t next = offset(a + da, b + db);
      if (std::exchange(seen[next], 1) == 0 && is_set(voxel(a + da, b + db))) found.push_back(next);
    }
  }
  area_mm2_ = static_cast<double>(found.size()) * grid_.spacing_mm[a_] * grid_.spacing_mm[b_];
  voxels_ = std::move(found);
}

std::vector<std::size_t> SliceRegion::voxels() const {
  std::vector<std::size_t> offsets;
  offsets.reserve(voxels_.size());
  for (const std::size_t at : voxels_)
    offsets.push_back(voxel(static_cast<int>(at) % size_a(), static_cast<int>(at) / size_a()));
  return offsets;
}

std::vector<Eigen::Vector2d> SliceRegion::outline() const {
  std::vector<std::uint8_t> set(count());
  for (const std::size_t at : voxels_) set[at] = 1;
  const auto is_set = [&](int a, int b) { return contains(a, b) && set[offset(a, b)] != 0; };
  const std::size_t first = *std::ranges::min_element(voxels_);
  const std::array<int, 2> begin{static_cast<int>(first) % size_a(), static_cast<int>(first) / size_a()};
  // Voxels ahead on the left and on the right of a step in the directions +a, +b, -a, -b, relative to the corner.
  constexpr int kStep[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  constexpr int kLeft[4][2] = {{0, 0}, {-1, 0}, {-1, -1}, {0, -1}};
  constexpr int kRight[4][2] = {{0, -1}, {0, 0}, {-1, 0}, {-1, -1}};
  std::vector<Eigen::Vector2d> corners;
  std::array<int, 2> at = begin;
  int direction = 0;
  do {
    corners.emplace_back(at[0] - 0.5, at[1] - 0.5);
    at[0] += kStep[direction][0], at[1] += kStep[direction][1];
    if (!is_set(at[0] + kLeft[direction][0], at[1] + kLeft[direction][1]))
      direction = (direction + 1) % 4;
    else if (is_set(at[0] + kRight[direction][0], at[1] + kRight[direction][1]))
      direction = (direction + 3) % 4;
  } while (at != begin || direction != 0);
  return corners;
}

std::vector<Eigen::Vector3d> SliceRegion::middle() {
  find_depth();
  const std::size_t first = farthest(start()), last = farthest(first);
  std::vector<Eigen::Vector3d> path;
  for (std::size_t at = last;; at = before_[at]) {
    path.push_back(place(at));
    if (at == first) return path;
  }
}

std::array<std::array<int, 2>, 2> SliceRegion::bounds() const {
  std::array<std::array<int, 2>, 2> bounds{{{size_a(), -1}, {size_b(), -1}}};
  for (const std::size_t at : voxels_) {
    const int index[2]{static_cast<int>(at) % size_a(), static_cast<int>(at) / size_a()};
    for (int x = 0; x < 2; ++x) {
      bounds[x][0] = std::min(bounds[x][0], index[x]);
      bounds[x][1] = std::max(bounds[x][1], index[x]);
    }
  }
  return bounds;
}

Eigen::Vector3d SliceRegion::place(double a, double b) const {
  Eigen::Vector3d index(fixed_[0], fixed_[1], fixed_[2]);
  index[a_] = a, index[b_] = b;
  return grid_.world_from_index() * index;
}

Eigen::Matrix<double, 3, 2> SliceRegion::axes() const {
  const Eigen::Matrix3d world = grid_.world_from_index().linear();
  Eigen::Matrix<double, 3, 2> axes;
  axes << world.col(a_), world.col(b_);
  return axes;
}

Eigen::Vector3d SliceRegion::normal() const {
  const Eigen::Matrix<double, 3, 2> along = axes();
  return along.col(0).cross(along.col(1)).normalized();
}

std::array<int, 3> SliceRegion::index(int a, int b) const {
  std::array<int, 3> index = fixed_;
  index[a_] = a, index[b_] = b;
  return index;
}

std::size_t SliceRegion::voxel(int a, int b) const {
  const std::array<int, 3> at = index(a, b);
  return VoxelBox{{0, 0, 0}, grid_.size}.offset(at[0], at[1], at[2]);
}

Eigen::Vector3d SliceRegion::place(std::size_t at) const {
  const std::array<int, 3> i = index(static_cast<int>(at) % size_a(), static_cast<int>(at) / size_a());
  return grid_.world_from_index() * Eigen::Vector3d(i[0], i[1], i[2]);
}

/// Distance of each voxel to the nearest one outside the region in the slice. The slice is surrounded by such voxels.
void SliceRegion::find_depth() {
  const VoxelBox box{{-1, -1, 0}, {size_a() + 2, size_b() + 2, 1}};
  std::vector<std::uint8_t> other(box.voxel_count(), 1);
  const auto in_box = [&](std::size_t at) {
    return box.offset(static_cast<int>(at) % size_a() + 1, static_cast<int>(at) / size_a() + 1, 0);
  };
  for (const std::size_t at : voxels_) other[in_box(at)] = 0;
  const Eigen::Matrix3d mm = Eigen::Vector3d(grid_.spacing_mm[a_], grid_.spacing_mm[b_], 1).asDiagonal();
  const std::vector<float> depth = distance_map(other, box, mm);
  depth_.assign(count(), 0);
  for (const std::size_t at : voxels_) deepest_ = std::max(deepest_, depth_[at] = depth[in_box(at)]);
}

/// Voxel of the path with the largest distance from another one, over voxels that are deep enough; fills `before_`.
/// The cost of a step decreases with the depth, so that the path stays in the middle.
std::size_t SliceRegion::farthest(std::size_t from) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<double> cost(count(), kFar), length(count(), 0);
  before_.assign(count(), from);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost[from] = 0;
  open.emplace(0, from);
  std::size_t best = from;
  while (!open.empty()) {
    const auto [c, at] = open.top();
    open.pop();
    if (c > cost[at]) continue;
    if (length[at] > length[best]) best = at;
    const int a = static_cast<int>(at) % size_a(), b = static_cast<int>(at) / size_a();
    for (int db = -1; db <= 1; ++db)
      for (int da = -1; da <= 1; ++da) {
        if ((da == 0 && db == 0) || !contains(a + da, b + db)) continue;
        const std::size_t next = offset(a + da, b + db);
        if (depth_[next] <= 0 || (depth_[next] < kLeastDepth * deepest_ && next != start())) continue;
        const double step = std::hypot(da * grid_.spacing_mm[a_], db * grid_.spacing_mm[b_]);
        const double ratio = deepest_ / depth_[next], through = c + step * ratio * ratio;
        if (through >= cost[next]) continue;
        cost[next] = through, length[next] = length[at] + step, before_[next] = at;
        open.emplace(through, next);
      }
  }
  return best;
}

}  // namespace simplexseg
