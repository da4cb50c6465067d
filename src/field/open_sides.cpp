// SPDX-License-Identifier: Apache-2.0
#include "field/open_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/expect.h"
#include "field/box_grid.h"

namespace simplexseg {
namespace {

constexpr double kContactCells = 4;  // largest distance of the object from a side that cuts it, smallest spacings
constexpr int kLeastContact = 9;     // cells of a section
constexpr int kRing = 3;             // the second and the third cell beside a section are its outside
constexpr int kIntensityBins = 64;
constexpr double kBinSmoothing = 2;       // Gaussian of the histograms, bins
constexpr double kLeastSeparation = 0.7;  // mean share of inside and outside that the intensity classifies right
constexpr double kLeastKept = 0.4;        // area of the section at the side, of that of the object near it
constexpr double kLeastEnclosed = 0.75;   // share of the cells around the continued sections that resemble the outside

/// Largest number of cells between a side of the volume and an object that it cuts.
int contact_layers(const VolumeGeometry& geometry, int axis) {
  return std::max(
      1, static_cast<int>(std::lround(kContactCells * geometry.spacing_mm.minCoeff() / geometry.spacing_mm[axis])));
}

/// Histogram of intensities, smoothed.
class Intensities {
 public:
  void add(float value) { ++count_[bin(value)], ++all_; }
  long all() const { return all_; }
  /// Share of the values in the bin of `value`.
  double density(int b) const {
    double sum = 0, weight = 0;
    const int reach = static_cast<int>(3 * kBinSmoothing);
    for (int d = -reach; d <= reach; ++d) {
      if (b + d < 0 || b + d >= kIntensityBins) continue;
      const double w = std::exp(-0.5 * d * d / (kBinSmoothing * kBinSmoothing));
      sum += w * static_cast<double>(count_[b + d]), weight += w;
    }
    return sum / (weight * static_cast<double>(std::max(1L, all_)));
  }
  /// Share of the values for which is[bin] is true.
  double share(const std::array<bool, kIntensityBins>& is) const {
    long sum = 0;
    for (int b = 0; b < kIntensityBins; ++b) sum += is[b] ? count_[b] : 0;
    return all_ == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(all_);
  }
  static int bin(float value) { return std::clamp(static_cast<int>(value * kIntensityBins), 0, kIntensityBins - 1); }

 private:
  std::array<long, kIntensityBins> count_{};
  long all_ = 0;
};

/// One side of a box: columns of cells from it inward.
class Side {
 public:
  Side(const VolumeGeometry& geometry, const VoxelBox& box, int axis, bool last, std::span<const std::uint8_t> object,
       std::span<const float> image, std::span<const Constraint> constraints)
      : object_(object), image_(image), constraints_(constraints), rows_{(axis + 1) % 3, (axis + 2) % 3} {
    const BoxGrid grid{box.size};
    length_ = box.size[axis];
    inward_ = last ? -grid.stride(axis) : grid.stride(axis);
    first_ = last ? (length_ - 1) * grid.stride(axis) : 0;
    for (int r = 0; r < 2; ++r) size_[r] = box.size[rows_[r]], stride_[r] = grid.stride(rows_[r]);
    depth_ = contact_layers(geometry, axis);
    depth_ = std::min(depth_, length_ - 1);
  }

  bool is_cut() const {
    std::vector<std::uint8_t> section = object_in(depth_);
    const long start = count(section);
    if (start < kLeastContact) return false;
    Intensities inner, outer, around;
    for (int t = depth_; t < std::min(length_, 2 * depth_ + 1); ++t) {
      const std::vector<std::uint8_t> is = object_in(t);
      each_cell([&](int x, int y) {
        if (is[at(x, y)]) add(inner, cell(x, y, t));
        if (is_beside(is, x, y)) add(outer, cell(x, y, t));
      });
    }
    if (outer.all() == 0) return false;
    std::array<bool, kIntensityBins> like_inside{}, like_outside{};
    for (int b = 0; b < kIntensityBins; ++b) {
      like_inside[b] = inner.density(b) > outer.density(b);
      like_outside[b] = !like_inside[b];
    }
    const double right_in = inner.share(like_inside), right_out = outer.share(like_outside);
    // Continues the section to the side, layer by layer, through cells that resemble the inside.
    for (int t = depth_ - 1; t >= 0; --t) {
      const std::vector<std::uint8_t> is = object_in(t), last = section;
      each_cell([&](int x, int y) {
        const int v = cell(x, y, t);
        const bool resembles = constraints_[v] != Constraint::NotFinite && like_inside[Intensities::bin(image_[v])];
        section[at(x, y)] =
            (t == 0 ? constraints_[v] == Constraint::Inside : is[at(x, y)] != 0) || (resembles && is_near(last, x, y));
      });
      each_cell([&](int x, int y) {
        if (is_beside(section, x, y)) add(around, cell(x, y, t));
      });
    }
    const double kept = static_cast<double>(count(section)) / static_cast<double>(start);
    return count(section) >= kLeastContact && kept >= kLeastKept && 0.5 * (right_in + right_out) >= kLeastSeparation &&
           around.share(like_outside) >= kLeastEnclosed;
  }

 private:
  int cell(int x, int y, int t) const { return first_ + t * inward_ + x * stride_[0] + y * stride_[1]; }
  void add(Intensities& to, int v) const {
    if (constraints_[v] != Constraint::NotFinite) to.add(image_[v]);
  }
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * size_[0] + x; }
  template <class Visit>
  void each_cell(const Visit& visit) const {
    for (int y = 0; y < size_[1]; ++y)
      for (int x = 0; x < size_[0]; ++x) visit(x, y);
  }
  static long count(const std::vector<std::uint8_t>& section) { return std::ranges::count(section, std::uint8_t{1}); }
  /// Object in a layer; the layer on the side itself repeats the next one and is replaced by is_cut().
  std::vector<std::uint8_t> object_in(int t) const {
    std::vector<std::uint8_t> is(static_cast<std::size_t>(size_[0]) * size_[1]);
    each_cell([&](int x, int y) { is[at(x, y)] = object_[cell(x, y, t)] != 0; });
    return is;
  }
  /// Whether a cell or one of its eight neighbours in the plane is in the section.
  bool is_near(const std::vector<std::uint8_t>& section, int x, int y) const {
    for (int v = std::max(0, y - 1); v <= std::min(size_[1] - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(size_[0] - 1, x + 1); ++u)
        if (section[at(u, v)]) return true;
    return false;
  }
  /// Whether a cell of the plane is two to kRing cells away, along an axis, from the section.
  bool is_beside(const std::vector<std::uint8_t>& section, int x, int y) const {
    if (section[at(x, y)]) return false;
    for (int d = 1; d <= kRing; ++d) {
      const bool near = (x >= d && section[at(x - d, y)]) || (x + d < size_[0] && section[at(x + d, y)]) ||
                        (y >= d && section[at(x, y - d)]) || (y + d < size_[1] && section[at(x, y + d)]);
      if (near) return d > 1;
    }
    return false;
  }

  std::span<const std::uint8_t> object_;
  std::span<const float> image_;
  std::span<const Constraint> constraints_;
  std::array<int, 2> rows_, size_{}, stride_{};
  int length_, inward_, first_, depth_;
};

}  // namespace

bool is_near_closed_side(const VolumeGeometry& geometry, const VoxelBox& box, const VoxelBox& object,
                         const BoxSides& open) {
  if (object.voxel_count() == 0) return false;
  for (int a = 0; a < 3; ++a) {
    const int near = contact_layers(geometry, a);
    if (box.first[a] == 0 && !open.first[a] && object.first[a] <= near) return true;
    const int above = geometry.size[a] - object.first[a] - object.size[a];
    if (box.first[a] + box.size[a] == geometry.size[a] && !open.last[a] && above <= near) return true;
  }
  return false;
}

BoxSides cut_sides(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const std::uint8_t> object,
                   std::span<const float> image, std::span<const Constraint> constraints, const BoxSides& open) {
  SIMPLEXSEG_EXPECT(object.size() == box.voxel_count() && image.size() == object.size() &&
                    constraints.size() == object.size());
  BoxSides cut;
  for (int a = 0; a < 3; ++a) {
    if (box.size[a] < 3) continue;
    for (const bool last : {false, true}) {
      const bool own = last ? box.first[a] + box.size[a] == geometry.size[a] : box.first[a] == 0;
      if (!own || (last ? open.last : open.first)[a]) continue;
      (last ? cut.last : cut.first)[a] = Side(geometry, box, a, last, object, image, constraints).is_cut();
    }
  }
  return cut;
}

}  // namespace simplexseg
