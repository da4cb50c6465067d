// SPDX-License-Identifier: Apache-2.0
#include "core/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/error.h"

namespace simplexseg {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string size_text(const VolumeGeometry& g) {
  return std::to_string(g.size[0]) + " x " + std::to_string(g.size[1]) + " x " + std::to_string(g.size[2]);
}

void require_same_grid(const Mask& reference, const Mask& test) {
  for (const Mask* mask : {&reference, &test}) {
    if (mask->voxels.size() != mask->geometry.voxel_count())
      throw Error(
          "mask",
          "it holds " + std::to_string(mask->voxels.size()) + " voxels on a grid of " + size_text(mask->geometry),
          "make it with mask_of or rasterise");
  }
  if (!reference.geometry.same_grid(test.geometry)) {
    const bool same_size = reference.geometry.size == test.geometry.size;
    throw Error("masks cannot be compared",
                same_size ? "their grids have the same size but lie at different places"
                          : "their grids differ (" + size_text(reference.geometry) + " against " +
                                size_text(test.geometry) + ")",
                "resample one onto the grid of the other");
  }
}

struct Counts {
  std::size_t reference = 0, test = 0, both = 0;
  double dice() const { return reference + test == 0 ? 1.0 : 2.0 * both / static_cast<double>(reference + test); }
};

Counts count(const Mask& reference, const Mask& test) {
  Counts counts;
  for (std::size_t v = 0; v < reference.voxels.size(); ++v) {
    const bool a = reference.voxels[v] != 0, b = test.voxels[v] != 0;
    counts.reference += a;
    counts.test += b;
    counts.both += a && b;
  }
  return counts;
}

/// Part of a grid: all that the distances of two masks depend on.
struct Box {
  std::array<int, 3> first, size;
  std::size_t offset(int i, int j, int k) const { return (static_cast<std::size_t>(k) * size[1] + j) * size[0] + i; }
  std::size_t voxel_count() const { return static_cast<std::size_t>(size[0]) * size[1] * size[2]; }
};

/// The smallest box that holds the set voxels of both masks, of which there must be one.
Box bounding_box(const Mask& a, const Mask& b) {
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
  return {low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1}};
}

/// 1 where a voxel of the mask has a 6-neighbour outside the mask or outside the image.
std::vector<std::uint8_t> boundary_of(const Mask& mask, const Box& box) {
  const auto [ni, nj, nk] = mask.geometry.size;
  const std::vector<std::uint8_t> outside(ni, 0);
  const auto row = [&, ni = ni, nj = nj, nk = nk](int j, int k) {
    return j < 0 || j >= nj || k < 0 || k >= nk ? outside.data()
                                                : mask.voxels.data() + (static_cast<std::size_t>(k) * nj + j) * ni;
  };
  std::vector<std::uint8_t> boundary(box.voxel_count());
  for (int k = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      const int gj = box.first[1] + j, gk = box.first[2] + k;
      const std::uint8_t *here = row(gj, gk), *below = row(gj - 1, gk), *above = row(gj + 1, gk);
      const std::uint8_t *before = row(gj, gk - 1), *behind = row(gj, gk + 1);
      std::uint8_t* out = boundary.data() + box.offset(0, j, k);
      for (int i = 0; i < box.size[0]; ++i) {
        const int gi = box.first[0] + i;
        if (!here[gi]) continue;
        const bool inner =
            gi > 0 && gi + 1 < ni && here[gi - 1] && here[gi + 1] && below[gi] && above[gi] && before[gi] && behind[gi];
        out[i] = !inner;
      }
    }
  }
  return boundary;
}

/// The lower envelope of the parabolas f(q) + (s (x - q))^2 over one line of voxels: one pass of the exact Euclidean
/// distance transform (Felzenszwalb and Huttenlocher 2012, Distance Transforms of Sampled Functions).
class Envelope {
 public:
  explicit Envelope(int capacity) : site_(capacity), from_(capacity + 1), height_(capacity) {}

  /// `squared(q)` is the squared distance at voxel q, infinite where there is none.
  template <class F>
  void build(int n, double spacing, F&& squared) {
    scale_ = spacing * spacing;
    count_ = 0;
    for (int q = 0; q < n; ++q) {
      const double h = squared(q);
      if (h == infinity) continue;
      double x = -infinity;
      while (count_ > 0) {
        const int p = site_[count_ - 1];
        x = 0.5 * (q + p + (h - height_[count_ - 1]) / (scale_ * (q - p)));
        if (x > from_[count_ - 1]) break;
        x = -infinity;
        --count_;
      }
      site_[count_] = q;
      height_[count_] = h;
      from_[count_++] = x;
    }
    from_[count_] = infinity;
  }
  bool empty() const { return count_ == 0; }
  void rewind() { at_ = 0; }
  /// Squared distance at voxel x; after rewind(), x must not decrease from call to call.
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

/// Distance (mm) from each set voxel of `from` to the nearest set voxel of `to`, orthogonal axes.
std::vector<double> separable_distances(const std::vector<std::uint8_t>& from, const std::vector<std::uint8_t>& to,
                                        const Box& box, const Eigen::Vector3d& spacing_mm) {
  const auto [ni, nj, nk] = box.size;
  std::vector<double> squared(box.voxel_count());
  Envelope envelope(std::max(nj, nk));
  const double far = 2.0 * ni;
  for (int k = 0; k < nk; ++k) {
    double* plane = squared.data() + box.offset(0, 0, k);
    for (int j = 0; j < nj; ++j) {
      const std::uint8_t* sites = to.data() + box.offset(0, j, k);
      double* row = plane + static_cast<std::size_t>(j) * ni;
      double steps = far;
      for (int i = 0; i < ni; ++i) row[i] = steps = sites[i] ? 0 : steps + 1;
      steps = far;
      for (int i = ni - 1; i >= 0; --i) {
        steps = sites[i] ? 0 : steps + 1;
        const double d = std::min(row[i], steps);
        row[i] = d >= far ? infinity : (spacing_mm[0] * d) * (spacing_mm[0] * d);
      }
    }
    for (int i = 0; i < ni; ++i) {
      double* column = plane + i;
      envelope.build(nj, spacing_mm[1], [&, ni = ni](int q) { return column[static_cast<std::size_t>(q) * ni]; });
      if (envelope.empty()) continue;
      envelope.rewind();
      for (int j = 0; j < nj; ++j) column[static_cast<std::size_t>(j) * ni] = envelope(j);
    }
  }
  // The last pass is evaluated only where it is asked for; slabs of constant j are copied so that lines along k are
  // not read across the whole volume.
  std::vector<double> distances, slab(static_cast<std::size_t>(ni) * nk);
  for (int j = 0; j < nj; ++j) {
    for (int k = 0; k < nk; ++k) {
      const double* row = squared.data() + box.offset(0, j, k);
      for (int i = 0; i < ni; ++i) slab[static_cast<std::size_t>(i) * nk + k] = row[i];
    }
    for (int i = 0; i < ni; ++i) {
      bool built = false;
      for (int k = 0; k < nk; ++k) {
        if (!from[box.offset(i, j, k)]) continue;
        if (!built) {
          const double* line = slab.data() + static_cast<std::size_t>(i) * nk;
          envelope.build(nk, spacing_mm[2], [&](int q) { return line[q]; });
          envelope.rewind();
          built = true;
        }
        distances.push_back(std::sqrt(envelope(k)));
      }
    }
  }
  return distances;
}

std::vector<Eigen::Vector3d> points_of(const std::vector<std::uint8_t>& set, const Box& box,
                                       const Eigen::Matrix3d& mm_from_index) {
  std::vector<Eigen::Vector3d> points;
  std::size_t v = 0;
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i)
        if (set[v++]) points.push_back(mm_from_index * Eigen::Vector3d(i, j, k));
  return points;
}

/// Nearest point by an implicit balanced k-d tree: the middle of a range splits it. For sheared grids, whose distance
/// is not separable.
class NearestPoint {
 public:
  explicit NearestPoint(std::vector<Eigen::Vector3d> points) : points_(std::move(points)), axis_(points_.size()) {
    build(0, points_.size());
  }
  /// `start`: any squared distance known to be reached, or infinity.
  double squared_distance(const Eigen::Vector3d& query, double start = infinity) const {
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
    // Neighbouring queries have neighbouring answers: by the triangle inequality the last answer bounds this one. The
    // margin keeps the bound above the true distance in spite of rounding.
    double bound = infinity;
    if (!distances.empty()) {
      const double reach = distances.back() + (point - from[distances.size() - 1]).norm();
      bound = reach * reach * (1 + 1e-9) + 1e-12;
    }
    distances.push_back(std::sqrt(nearest.squared_distance(point, bound)));
  }
  return distances;
}

struct Directed {
  double max, percentile95, mean;
};

/// Reorders `distances`, which must not be empty. The percentile interpolates linearly between order statistics.
Directed summarise(std::vector<double>& distances) {
  const double rank = 0.95 * static_cast<double>(distances.size() - 1);
  const auto low = distances.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(distances.begin(), low, distances.end());
  const double next = low + 1 == distances.end() ? *low : *std::min_element(low + 1, distances.end());
  return {*std::max_element(low, distances.end()), *low + (rank - std::floor(rank)) * (next - *low),
          std::accumulate(distances.begin(), distances.end(), 0.0) / static_cast<double>(distances.size())};
}

}  // namespace

Mask mask_of(const Volume& labels, std::optional<double> label) {
  Mask mask{labels.geometry(), std::vector<std::uint8_t>(labels.empty() ? 0 : labels.geometry().voxel_count())};
  if (labels.empty()) return mask;
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = labels.voxels<T>();
    if (!label) {
      // The second comparison leaves out NaN, which some tools write as background.
      for (std::size_t v = 0; v < voxels.size(); ++v) mask.voxels[v] = voxels[v] != T(0) && voxels[v] == voxels[v];
    } else if (*label >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
               *label <= static_cast<double>(std::numeric_limits<T>::max()) &&
               static_cast<double>(static_cast<T>(*label)) == *label) {
      const T wanted = static_cast<T>(*label);
      for (std::size_t v = 0; v < voxels.size(); ++v) mask.voxels[v] = voxels[v] == wanted;
    }
  });
  return mask;
}

double dice(const Mask& reference, const Mask& test) {
  require_same_grid(reference, test);
  return count(reference, test).dice();
}

Agreement compare(const Mask& reference, const Mask& test) {
  require_same_grid(reference, test);
  const Counts counts = count(reference, test);
  const Eigen::Matrix3d mm_from_index = reference.geometry.world_from_index().linear();
  const double voxel_mm3 = std::abs(mm_from_index.determinant());
  Agreement result{};
  result.dice = counts.dice();
  result.reference_mm3 = counts.reference * voxel_mm3;
  result.test_mm3 = counts.test * voxel_mm3;
  if (counts.reference == 0 && counts.test == 0) return result;
  if (counts.reference == 0 || counts.test == 0) {
    result.hd_mm = result.hd95_mm = result.assd_mm = infinity;
    result.hd_directed_mm = result.hd95_directed_mm = result.asd_directed_mm = infinity;
    return result;
  }
  const Box box = bounding_box(reference, test);
  const std::vector<std::uint8_t> reference_boundary = boundary_of(reference, box);
  const std::vector<std::uint8_t> test_boundary = boundary_of(test, box);

  const Eigen::Vector3d spacing_mm = mm_from_index.colwise().norm();
  const Eigen::Matrix3d unit = mm_from_index * spacing_mm.cwiseInverse().asDiagonal();
  const Eigen::Matrix3d cosines = unit.transpose() * unit - Eigen::Matrix3d::Identity();
  // Headers give orthogonal directions to 6 or 7 digits; an angle off by 1e-5 changes a distance by at most that share.
  const bool orthogonal = cosines.cwiseAbs().maxCoeff() < 1e-5;
  std::vector<double> to_test, to_reference;
  if (orthogonal) {
    to_test = separable_distances(reference_boundary, test_boundary, box, spacing_mm);
    to_reference = separable_distances(test_boundary, reference_boundary, box, spacing_mm);
  } else {
    const auto reference_points = points_of(reference_boundary, box, mm_from_index);
    const auto test_points = points_of(test_boundary, box, mm_from_index);
    to_test = point_distances(reference_points, test_points);
    to_reference = point_distances(test_points, reference_points);
  }
  const Directed forth = summarise(to_test), back = summarise(to_reference);
  result.hd_directed_mm = forth.max;
  result.hd95_directed_mm = forth.percentile95;
  result.asd_directed_mm = forth.mean;
  result.hd_mm = std::max(forth.max, back.max);
  result.hd95_mm = std::max(forth.percentile95, back.percentile95);
  result.assd_mm = 0.5 * (forth.mean + back.mean);
  return result;
}

}  // namespace simplexseg
