// SPDX-License-Identifier: Apache-2.0
#include "field/robot_stroke.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <random>
#include <utility>

#include "core/error.h"
#include "image/distance_map.h"

namespace simplexseg {
namespace {

constexpr double kLeastDepth = 0.5;      // of the depth of a voxel on the path, relative to the largest in the slice
constexpr double kJitterVoxels = 0.5;    // largest deviation of the hand, voxels
constexpr int kJitterStep = 3;           // distance of the points at which the hand deviates, voxels of the path
constexpr double kBoxNoiseVoxels = 1;    // largest deviation of the side of a box, voxels
constexpr double kLateStopVoxels = 1.5;  // largest length by which the hand stops too late, voxels

/// Voxels of an error in a slice, with their depth.
class ErrorInSlice {
 public:
  /// `axis`: index axis perpendicular to the slice.
  ErrorInSlice(const Mask& truth, const Mask& now, const WorstError& error, int axis) : geometry_(truth.geometry) {
    a_ = axis == 0 ? 1 : 0, b_ = axis == 2 ? 1 : 2;
    fixed_ = error.voxel;
    const auto is_error = [&](int a, int b) {
      const std::size_t v = voxel(a, b);
      return truth.voxels[v] != now.voxels[v] && (truth.voxels[v] != 0) == error.too_little;
    };
    std::vector<std::uint8_t> seen(count());
    std::vector<std::size_t> found{start()};
    seen[start()] = 1;
    for (std::size_t n = 0; n < found.size(); ++n) {
      const int a = static_cast<int>(found[n]) % size_a(), b = static_cast<int>(found[n]) / size_a();
      for (const auto& [da, db] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        if (!contains(a + da, b + db)) continue;
        const std::size_t next = offset(a + da, b + db);
        if (std::exchange(seen[next], 1) == 0 && is_error(a + da, b + db)) found.push_back(next);
      }
    }
    area_mm2_ = static_cast<double>(found.size()) * geometry_.spacing_mm[a_] * geometry_.spacing_mm[b_];
    voxels_ = std::move(found);
  }

  double area_mm2() const { return area_mm2_; }
  std::size_t voxel_count() const { return voxels_.size(); }
  int axis() const { return 3 - a_ - b_; }

  /// Corners of the voxels along the outer border, counter-clockwise, as fractional indices of the slice.
  std::vector<Eigen::Vector2d> outline() const {
    std::vector<std::uint8_t> set(count());
    for (const std::size_t at : voxels_) set[at] = 1;
    const auto is_set = [&](int a, int b) { return contains(a, b) && set[offset(a, b)] != 0; };
    const std::size_t first = *std::ranges::min_element(voxels_);
    const std::array<int, 2> start{static_cast<int>(first) % size_a(), static_cast<int>(first) / size_a()};
    // Voxels ahead on the left and on the right of a step in the directions +a, +b, -a, -b, relative to the corner.
    constexpr int kStep[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    constexpr int kLeft[4][2] = {{0, 0}, {-1, 0}, {-1, -1}, {0, -1}};
    constexpr int kRight[4][2] = {{0, -1}, {0, 0}, {-1, 0}, {-1, -1}};
    std::vector<Eigen::Vector2d> corners;
    std::array<int, 2> at = start;
    int direction = 0;
    do {
      corners.emplace_back(at[0] - 0.5, at[1] - 0.5);
      at[0] += kStep[direction][0], at[1] += kStep[direction][1];
      if (!is_set(at[0] + kLeft[direction][0], at[1] + kLeft[direction][1]))
        direction = (direction + 1) % 4;
      else if (is_set(at[0] + kRight[direction][0], at[1] + kRight[direction][1]))
        direction = (direction + 3) % 4;
    } while (at != start || direction != 0);
    return corners;
  }

  /// Ends of the longest path along the middle, and the path between them, mm.
  std::vector<Eigen::Vector3d> middle() {
    find_depth();
    const std::size_t first = farthest(start()), last = farthest(first);
    std::vector<Eigen::Vector3d> path;
    for (std::size_t at = last;; at = before_[at]) {
      path.push_back(place(at));
      if (at == first) return path;
    }
  }

  /// First and last voxel of the error along both axes of the slice.
  std::array<std::array<int, 2>, 2> bounds() const {
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
  /// Place of fractional indices of the slice, mm.
  Eigen::Vector3d place(double a, double b) const {
    Eigen::Vector3d index(fixed_[0], fixed_[1], fixed_[2]);
    index[a_] = a, index[b_] = b;
    return geometry_.world_from_index() * index;
  }

  /// Unit vectors of the slice, mm per voxel.
  Eigen::Matrix<double, 3, 2> axes() const {
    const Eigen::Matrix3d world = geometry_.world_from_index().linear();
    Eigen::Matrix<double, 3, 2> axes;
    axes << world.col(a_), world.col(b_);
    return axes;
  }

 private:
  int size_a() const { return geometry_.size[a_]; }
  int size_b() const { return geometry_.size[b_]; }
  std::size_t count() const { return static_cast<std::size_t>(size_a()) * size_b(); }
  bool contains(int a, int b) const { return a >= 0 && b >= 0 && a < size_a() && b < size_b(); }
  std::size_t offset(int a, int b) const { return static_cast<std::size_t>(b) * size_a() + a; }
  std::size_t start() const { return offset(fixed_[a_], fixed_[b_]); }
  std::array<int, 3> index(int a, int b) const {
    std::array<int, 3> index = fixed_;
    index[a_] = a, index[b_] = b;
    return index;
  }
  std::size_t voxel(int a, int b) const {
    const std::array<int, 3> at = index(a, b);
    return VoxelBox{{0, 0, 0}, geometry_.size}.offset(at[0], at[1], at[2]);
  }
  Eigen::Vector3d place(std::size_t at) const {
    const std::array<int, 3> i = index(static_cast<int>(at) % size_a(), static_cast<int>(at) / size_a());
    return geometry_.world_from_index() * Eigen::Vector3d(i[0], i[1], i[2]);
  }

  /// Distance of each voxel to the nearest one outside the error in the slice. The slice is surrounded by such voxels.
  void find_depth() {
    const VoxelBox box{{-1, -1, 0}, {size_a() + 2, size_b() + 2, 1}};
    std::vector<std::uint8_t> other(box.voxel_count(), 1);
    const auto in_box = [&](std::size_t at) {
      return box.offset(static_cast<int>(at) % size_a() + 1, static_cast<int>(at) / size_a() + 1, 0);
    };
    for (const std::size_t at : voxels_) other[in_box(at)] = 0;
    const Eigen::Matrix3d mm = Eigen::Vector3d(geometry_.spacing_mm[a_], geometry_.spacing_mm[b_], 1).asDiagonal();
    const std::vector<float> depth = distance_map(other, box, mm);
    depth_.assign(count(), 0);
    for (const std::size_t at : voxels_) deepest_ = std::max(deepest_, depth_[at] = depth[in_box(at)]);
  }

  /// Voxel of the path with the largest distance from another one, over voxels that are deep enough; fills `before_`.
  /// The cost of a step decreases with the depth, so that the path stays in the middle.
  std::size_t farthest(std::size_t from) {
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
          const double step = std::hypot(da * geometry_.spacing_mm[a_], db * geometry_.spacing_mm[b_]);
          const double ratio = deepest_ / depth_[next], through = c + step * ratio * ratio;
          if (through >= cost[next]) continue;
          cost[next] = through, length[next] = length[at] + step, before_[next] = at;
          open.emplace(through, next);
        }
    }
    return best;
  }

  const VolumeGeometry& geometry_;
  int a_, b_;  // index axes of the slice
  std::array<int, 3> fixed_;
  double area_mm2_ = 0;
  std::vector<std::size_t> voxels_;
  std::vector<float> depth_;
  float deepest_ = 0;
  std::vector<std::size_t> before_;  // of the last farthest()
};

/// Slice through the deepest voxel of an error that shows most of it.
ErrorInSlice largest_slice(const Mask& truth, const Mask& now, const WorstError& error) {
  std::optional<ErrorInSlice> slice;
  for (int axis = 2; axis >= 0; --axis) {
    ErrorInSlice other(truth, now, error, axis);
    if (!slice || other.area_mm2() > slice->area_mm2()) slice.emplace(std::move(other));
  }
  return *std::move(slice);
}

/// Uniform number between -1 and 1, the same with every standard library.
double noise(std::mt19937& generator) { return 2 * (generator() / 4294967295.0) - 1; }

}  // namespace

std::optional<RobotLasso> lasso_at_error(const Mask& truth, const Mask& now, const WorstError& error, int lasso) {
  constexpr std::size_t kLeastVoxels = 4;
  require_same_grid(truth, now);
  const int axis = largest_slice(truth, now, error).axis();
  const Mask nothing{truth.geometry, std::vector<std::uint8_t>(truth.voxels.size())};
  const ErrorInSlice enclosed(truth, error.too_little ? nothing : now, error, axis);
  if (enclosed.voxel_count() < kLeastVoxels) return std::nullopt;
  const std::vector<Eigen::Vector2d> outline = enclosed.outline();
  std::mt19937 generator(static_cast<std::uint32_t>(lasso));
  RobotLasso drawn{error.too_little ? MarkKind::Inside : MarkKind::Outside, {}, {}};
  for (std::size_t p = 0; p < outline.size(); p += kJitterStep) {
    const double a = outline[p][0] + kJitterVoxels * noise(generator);
    const double b = outline[p][1] + kJitterVoxels * noise(generator);
    drawn.contour_mm.push_back(enclosed.place(a, b));
  }
  const Eigen::Matrix<double, 3, 2> axes = enclosed.axes();
  drawn.normal = axes.col(0).cross(axes.col(1)).normalized();
  return drawn;
}

BoxCorners box_around_object(const Mask& object, const WorstError& deepest) {
  const Mask nothing{object.geometry, std::vector<std::uint8_t>(object.voxels.size())};
  const ErrorInSlice slice = largest_slice(object, nothing, deepest);
  std::mt19937 generator(0);
  double side[2][2];
  for (int x = 0; x < 2; ++x)
    for (int end = 0; end < 2; ++end)
      side[x][end] = slice.bounds()[x][end] + (end == 0 ? -0.5 : 0.5) + kBoxNoiseVoxels * noise(generator);
  return {slice.place(side[0][0], side[1][0]), slice.place(side[0][1], side[1][0]), slice.place(side[0][1], side[1][1]),
          slice.place(side[0][0], side[1][1])};
}

std::vector<Eigen::Vector3d> stroke_in_error(const Mask& truth, const Mask& now, const WorstError& error, int stroke) {
  require_same_grid(truth, now);
  ErrorInSlice slice = largest_slice(truth, now, error);
  const std::vector<Eigen::Vector3d> middle = slice.middle();
  const Eigen::Matrix<double, 3, 2> axes = slice.axes();
  std::mt19937 generator(static_cast<std::uint32_t>(stroke));
  std::vector<Eigen::Vector3d> path;
  for (std::size_t p = 0; p < middle.size(); p += kJitterStep) {
    const Eigen::Vector2d deviation(noise(generator), noise(generator));
    path.emplace_back(middle[p] + kJitterVoxels * axes * deviation);
  }
  if (middle.size() > 1) {
    const double late = kLateStopVoxels * std::abs(noise(generator));
    const Eigen::Vector3d along = (middle.back() - middle[middle.size() - 2]).normalized();
    path.emplace_back(middle.back() + late * truth.geometry.spacing_mm.minCoeff() * along);
  }
  std::erase_if(path, [&](const Eigen::Vector3d& mm) { return !truth.geometry.contains(mm); });
  if (path.empty()) path.push_back(middle.front());
  return path;
}

}  // namespace simplexseg
