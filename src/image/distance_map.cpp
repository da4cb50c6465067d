// SPDX-License-Identifier: Apache-2.0
#include "image/distance_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/expect.h"

namespace simplexseg {
namespace {

/// Lower envelope of the parabolas f(q) + (s (x - q))^2 over a line of voxels of spacing s: one pass of the Euclidean
/// distance transform (Felzenszwalb and Huttenlocher 2012, Distance Transforms of Sampled Functions).
class Envelope {
 public:
  explicit Envelope(int capacity) : site_(capacity), from_(capacity + 1), height_(capacity) {}

  /// Builds the envelope of a line of n voxels. `squared(q)`: squared distance f(q), mm^2; kInfinity for no parabola.
  template <class F>
  void build(int n, double spacing, F&& squared) {
    scale_ = spacing * spacing;
    count_ = 0;
    for (int q = 0; q < n; ++q) {
      const double h = squared(q);
      if (h == kInfinity) continue;
      double x = -kInfinity;
      while (count_ > 0) {
        const int p = site_[count_ - 1];
        x = 0.5 * (q + p + (h - height_[count_ - 1]) / (scale_ * (q - p)));
        if (x > from_[count_ - 1]) break;
        x = -kInfinity;
        --count_;
      }
      site_[count_] = q;
      height_[count_] = h;
      from_[count_++] = x;
    }
    from_[count_] = kInfinity;
  }
  bool empty() const { return count_ == 0; }
  void rewind() { at_ = 0; }
  /// Squared distance at voxel x, mm^2. Between calls of rewind(), x must not decrease.
  double operator()(int x) {
    while (from_[at_ + 1] < x) ++at_;
    const double d = x - site_[at_];
    return height_[at_] + scale_ * d * d;
  }

 private:
  std::vector<int> site_;
  std::vector<double> from_, height_;
  double scale_ = 1;
  int count_ = 0, at_ = 0;
};

/// Calls report(offset, mm) for each voxel for which selected(offset) is true. `mm`: distance of the voxel to the
/// nearest set voxel of `to`; infinite or above `limit_mm` if that is farther than `limit_mm`. Requires orthogonal
/// axes.
template <class Selected, class Report>
void separable_distances(const std::vector<std::uint8_t>& to, const VoxelBox& box, const Eigen::Vector3d& spacing_mm,
                         double limit_mm, Selected&& selected, Report&& report) {
  const auto [ni, nj, nk] = box.size;
  // A parabola above the squared limit is the lowest at no voxel within the limit, whatever the rounding.
  const double most = limit_mm * limit_mm * (1 + 1e-3);
  std::vector<double> squared(box.voxel_count());
  Envelope envelope(std::max(nj, nk));
  const double far = 2.0 * ni;
  for (int k = 0; k < nk; ++k) {
    double* plane = squared.data() + box.offset(0, 0, k);
    for (int j = 0; j < nj; ++j) {
      const std::uint8_t* sites = to.data() + box.offset(0, j, k);
      double* row = plane + static_cast<std::size_t>(j) * ni;
      double distance = far;
      for (int i = 0; i < ni; ++i) row[i] = distance = sites[i] ? 0 : distance + 1;
      distance = far;
      for (int i = ni - 1; i >= 0; --i) {
        distance = sites[i] ? 0 : distance + 1;
        const double d = std::min(row[i], distance), mm2 = (spacing_mm[0] * d) * (spacing_mm[0] * d);
        row[i] = d >= far || mm2 > most ? kInfinity : mm2;
      }
    }
    for (int i = 0; i < ni; ++i) {
      double* column = plane + i;
      bool all_set = true;
      for (int j = 0; all_set && j < nj; ++j) all_set = column[static_cast<std::size_t>(j) * ni] == 0;
      if (all_set) continue;
      envelope.build(nj, spacing_mm[1], [&, ni = ni](int q) { return column[static_cast<std::size_t>(q) * ni]; });
      if (envelope.empty()) continue;
      envelope.rewind();
      for (int j = 0; j < nj; ++j) {
        const double mm2 = envelope(j);
        column[static_cast<std::size_t>(j) * ni] = mm2 > most ? kInfinity : mm2;
      }
    }
  }
  // Evaluates the last pass only at selected voxels. Copies slabs of constant j, because reading lines along k would
  // stride across the whole volume.
  std::vector<double> slab(static_cast<std::size_t>(ni) * nk);
  for (int j = 0; j < nj; ++j) {
    for (int k = 0; k < nk; ++k) {
      const double* row = squared.data() + box.offset(0, j, k);
      for (int i = 0; i < ni; ++i) slab[static_cast<std::size_t>(i) * nk + k] = row[i];
    }
    for (int i = 0; i < ni; ++i) {
      bool built = false;
      for (int k = 0; k < nk; ++k) {
        if (!selected(box.offset(i, j, k))) continue;
        if (!built) {
          const double* line = slab.data() + static_cast<std::size_t>(i) * nk;
          envelope.build(nk, spacing_mm[2], [&](int q) { return line[q]; });
          envelope.rewind();
          built = true;
        }
        report(box.offset(i, j, k), envelope.empty() ? kInfinity : std::sqrt(envelope(k)));
      }
    }
  }
}

std::vector<Eigen::Vector3d> points_of(const std::vector<std::uint8_t>& set, const VoxelBox& box,
                                       const Eigen::Matrix3d& mm_from_index) {
  std::vector<Eigen::Vector3d> points;
  std::size_t v = 0;
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i)
        if (set[v++]) points.push_back(mm_from_index * Eigen::Vector3d(i, j, k));
  return points;
}

/// Search for the nearest point in an implicit balanced k-d tree, which splits each range at its median. Used for
/// sheared grids, on which the distance transform is not separable.
class NearestPoint {
 public:
  explicit NearestPoint(std::vector<Eigen::Vector3d> points) : points_(std::move(points)), axis_(points_.size()) {
    build(0, points_.size());
  }
  /// Squared distance of the nearest point, mm^2. `start`: known upper bound of the result, or kInfinity.
  double squared_distance(const Eigen::Vector3d& query, double start = kInfinity) const {
    double best = start;
    search(query, 0, points_.size(), best);
    return best;
  }

 private:
  static constexpr std::size_t leaf_size = 12;

  void build(std::size_t first, std::size_t last) {
    if (last - first <= leaf_size) return;
    Eigen::Array3d low = points_[first], high = low;
    for (std::size_t p = first; p < last; ++p) {
      low = low.min(points_[p].array());
      high = high.max(points_[p].array());
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = first + (last - first) / 2;
    std::nth_element(points_.begin() + first, points_.begin() + middle, points_.begin() + last,
                     [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; });
    axis_[middle] = static_cast<std::uint8_t>(axis);
    build(first, middle);
    build(middle + 1, last);
  }
  void search(const Eigen::Vector3d& query, std::size_t first, std::size_t last, double& best) const {
    if (last - first <= leaf_size) {
      for (std::size_t p = first; p < last; ++p) best = std::min(best, (points_[p] - query).squaredNorm());
      return;
    }
    const std::size_t middle = first + (last - first) / 2;
    best = std::min(best, (points_[middle] - query).squaredNorm());
    const double side = query[axis_[middle]] - points_[middle][axis_[middle]];
    if (side < 0)
      search(query, first, middle, best);
    else
      search(query, middle + 1, last, best);
    if (side * side >= best) return;
    if (side < 0)
      search(query, middle + 1, last, best);
    else
      search(query, first, middle, best);
  }

  std::vector<Eigen::Vector3d> points_;
  std::vector<std::uint8_t> axis_;
};

std::vector<double> point_distances(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to) {
  const NearestPoint nearest(to);
  std::vector<double> distances;
  distances.reserve(from.size());
  for (const Eigen::Vector3d& point : from) {
    // By the triangle inequality, the distance of the previous query bounds this one. The margin accounts for rounding.
    double bound = kInfinity;
    if (!distances.empty()) {
      const double reach = distances.back() + (point - from[distances.size() - 1]).norm();
      bound = reach * reach * (1 + 1e-9) + 1e-12;
    }
    distances.push_back(std::sqrt(nearest.squared_distance(point, bound)));
  }
  return distances;
}

}  // namespace

// An angular error of 1e-5 changes a distance by at most a fraction of 1e-5.
bool are_orthogonal(const Eigen::Matrix3d& mm_from_index) {
  const Eigen::Matrix3d unit = mm_from_index * mm_from_index.colwise().norm().cwiseInverse().asDiagonal();
  return (unit.transpose() * unit - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-5;
}

std::vector<double> distances_between(const std::vector<std::uint8_t>& from, const std::vector<std::uint8_t>& to,
                                      const VoxelBox& box, const Eigen::Matrix3d& mm_from_index) {
  SIMPLEXSEG_EXPECT(from.size() == box.voxel_count() && to.size() == box.voxel_count());
  if (!are_orthogonal(mm_from_index))
    return point_distances(points_of(from, box, mm_from_index), points_of(to, box, mm_from_index));
  std::vector<double> distances;
  separable_distances(
      to, box, mm_from_index.colwise().norm(), kInfinity, [&](std::size_t v) { return from[v] != 0; },
      [&](std::size_t, double mm) { distances.push_back(mm); });
  return distances;
}

std::vector<float> distance_map(const std::vector<std::uint8_t>& to, const VoxelBox& box,
                                const Eigen::Matrix3d& mm_from_index, double limit_mm) {
  SIMPLEXSEG_EXPECT(to.size() == box.voxel_count() && limit_mm > 0);
  std::vector<float> map(box.voxel_count());
  if (are_orthogonal(mm_from_index)) {
    separable_distances(
        to, box, mm_from_index.colwise().norm(), limit_mm, [&](std::size_t v) { return to[v] == 0; },
        [&](std::size_t v, double mm) { map[v] = static_cast<float>(mm); });
  } else {
    const std::vector<std::uint8_t> all(box.voxel_count(), 1);
    const std::vector<double> distances =
        point_distances(points_of(all, box, mm_from_index), points_of(to, box, mm_from_index));
    std::copy(distances.begin(), distances.end(), map.begin());
  }
  if (limit_mm < kInfinity)
    for (float& mm : map)
      if (mm > limit_mm) mm = std::numeric_limits<float>::infinity();
  return map;
}

DistanceSummary summarise(std::vector<double>& distances) {
  SIMPLEXSEG_EXPECT(!distances.empty());
  const double rank = 0.95 * static_cast<double>(distances.size() - 1);
  const auto low = distances.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(distances.begin(), low, distances.end());
  const double next = low + 1 == distances.end() ? *low : *std::min_element(low + 1, distances.end());
  return {*std::max_element(low, distances.end()), *low + (rank - std::floor(rank)) * (next - *low),
          std::accumulate(distances.begin(), distances.end(), 0.0) / static_cast<double>(distances.size())};
}

}  // namespace simplexseg
