// SPDX-License-Identifier: Apache-2.0
#include "forces/region_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "image/rasterise.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

constexpr std::size_t kSamples = 1'000'000;  // approximate number for more than twice as many voxels; else all are used

/// Distance of the samples among `count` voxels. It is odd, thus coprime to row lengths that are powers of two, and
/// coprime to the length of `row` voxels, so that the samples fall into all columns.
std::size_t sample_stride(std::size_t count, std::size_t row) {
  std::size_t stride = std::max<std::size_t>(1, count / kSamples | 1);
  while (std::gcd(stride, row) > 1) stride += 2;
  return stride;
}

/// q-quantile of the values, 0 <= q <= 1. Reorders them.
template <class T>
double quantile_of(std::vector<T>& values, double q) {
  auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

/// Smallest width of an intensity range that exceeds rounding errors. It is relative to the intensities, since their
/// unit is arbitrary, and its inverse fits into a float.
double min_width(double low, double high) {
  const double size = std::max(std::abs(low), std::abs(high));
  return size > 0 ? std::max(1e-6 * size, 1e-37) : 1e-6;
}

int bin_of(double value, const RegionModel& model) {
  const double t = (value - model.low) / (model.high - model.low);
  return static_cast<int>(std::clamp(t, 0.0, 1.0) * (kRegionBins - 1) + 0.5);
}

}  // namespace

bool RegionModel::empty() const {
  auto none = [](const auto& h) { return std::all_of(h.begin(), h.end(), [](int n) { return n == 0; }); };
  return none(object) || none(background);
}

IntensityWindow intensity_window(const Volume& volume) {
  IntensityWindow window;
  if (volume.empty()) return window;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    const std::size_t stride = sample_stride(voxels.size(), volume.geometry().size[0]);
    std::vector<double> values;
    values.reserve(voxels.size() / stride + 1);
    for (std::size_t k = 0; k < voxels.size(); k += stride)
      if (std::isfinite(static_cast<double>(voxels[k]))) values.push_back(static_cast<double>(voxels[k]));
    if (values.empty()) return;
    window = {quantile_of(values, 0.005), quantile_of(values, 0.995)};
    if (!(window.high - window.low > min_width(window.low, window.high))) {  // few bright voxels, or a constant image
      const auto [lowest, highest] = std::minmax_element(values.begin(), values.end());
      window = {*lowest, *highest};
      const double width = min_width(window.low, window.high);
      if (!(window.high - window.low > width)) window.high = window.low + 1e6 * width;
    }
  });
  return window;
}

RegionModel estimate_region(const Volume& volume, const SimplexMesh& mesh, double margin_mm) {
  RegionModel model;
  if (volume.empty() || mesh.positions.empty()) return model;
  const VolumeGeometry& g = volume.geometry();
  // Bounding box of the mesh in index space, enlarged by the margin. Voxels outside this box are ignored.
  Eigen::Array3d box_low = Eigen::Array3d::Constant(1e30), box_high = -box_low;
  const Eigen::Affine3d index_from_world = g.index_from_world();
  for (const Eigen::Vector3f& p : mesh.positions) {
    const Eigen::Array3d q = (index_from_world * p.cast<double>()).array();
    box_low = box_low.min(q), box_high = box_high.max(q);
  }
  const Eigen::Array3d grow = margin_mm / g.spacing_mm.array();
  int first[3];
  VolumeGeometry box = g;
  for (int k = 0; k < 3; ++k) {
    first[k] = static_cast<int>(std::clamp(std::floor(box_low[k] - grow[k]), 0.0, g.size[k] - 1.0));
    const int last = static_cast<int>(std::clamp(std::ceil(box_high[k] + grow[k]), 0.0, g.size[k] - 1.0));
    box.size[k] = last - first[k] + 1;
  }
  box.origin_mm = g.world_from_index() * Eigen::Vector3d(first[0], first[1], first[2]);
  const Mask inside = rasterise(mesh, box);
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    std::vector<T> object, background;
    const std::size_t row = box.size[0], rows = box.size[1], count = inside.voxels.size();
    const std::size_t in_mesh = std::ranges::count(inside.voxels, std::uint8_t{1});
    const std::size_t strides[]{sample_stride(count - in_mesh, row), sample_stride(in_mesh, row)};
    std::size_t until_next[]{0, 0};  // number of voxels until the next sample
    for (std::size_t n = 0; n < count; ++n) {
      const std::uint8_t in = inside.voxels[n];
      if (until_next[in]-- > 0) continue;
      until_next[in] = strides[in] - 1;
      const T value =
          voxels[volume.offset(first[0] + static_cast<int>(n % row), first[1] + static_cast<int>(n / row % rows),
                               first[2] + static_cast<int>(n / row / rows))];
      if (std::isfinite(static_cast<double>(value))) (in != 0 ? object : background).push_back(value);
    }
    if (object.empty() || background.empty()) return;
    const double low = std::min(quantile_of(object, 0.02), quantile_of(background, 0.1));
    const double high = std::max(quantile_of(object, 0.98), quantile_of(background, 0.9));
    const double margin = std::max(0.25 * (high - low), min_width(low, high));
    model.low = low - margin, model.high = high + margin;
    for (const T value : object) ++model.object[bin_of(static_cast<double>(value), model)];
    for (const T value : background) ++model.background[bin_of(static_cast<double>(value), model)];
  });
  return model;
}

std::array<float, kRegionBins> log_likelihood_ratios(const RegionModel& model) {
  std::array<float, kRegionBins> ratios{};
  if (model.empty()) return ratios;
  // Gaussian kernel over bins with the bandwidth of Silverman's rule.
  auto smooth = [](const std::array<std::int32_t, kRegionBins>& counts) {
    const double n = std::accumulate(counts.begin(), counts.end(), 0.0);
    double mean = 0, square = 0;
    for (int b = 0; b < kRegionBins; ++b) mean += b * (counts[b] / n);
    for (int b = 0; b < kRegionBins; ++b) square += (b - mean) * (b - mean) * (counts[b] / n);
    const double sigma = std::clamp(1.06 * std::sqrt(square) * std::pow(n, -0.2), 1.5, 20.0);
    std::array<double, kRegionBins> density{};
    const int reach = static_cast<int>(3 * sigma) + 1;
    for (int b = 0; b < kRegionBins; ++b) {
      if (counts[b] == 0) continue;
      for (int d = -reach; d <= reach; ++d)
        density[std::clamp(b + d, 0, kRegionBins - 1)] +=
            counts[b] / n * std::exp(-0.5 * d * d / (sigma * sigma)) / (sigma * 2.5066);
    }
    return density;
  };
  const auto object = smooth(model.object), background = smooth(model.background);
  constexpr double kFloor = 1e-4;  // intensities absent from both histograms give no evidence
  for (int b = 0; b < kRegionBins; ++b)
    ratios[b] = static_cast<float>(std::clamp(std::log((object[b] + kFloor) / (background[b] + kFloor)), -1.0, 1.0));
  return ratios;
}

}  // namespace simplexseg
