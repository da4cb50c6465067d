// SPDX-License-Identifier: Apache-2.0
#include "field/box_image.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "core/quantile.h"

namespace simplexseg {
namespace {

/// Writes out[l], 0 <= l < Count: values around centre[l], `step` apart, convolved with a symmetric kernel.
template <int Count>
void convolve(const float* centre, int step, std::span<const float> kernel, float* out) {
  std::array<float, Count> sum;  // in registers
#pragma GCC unroll 32
  for (int l = 0; l < Count; ++l) sum[l] = kernel[0] * centre[l];
  for (std::ptrdiff_t d = 1; d < std::ssize(kernel); ++d) {
    const float *const a = centre - d * step, *const b = centre + d * step;
#pragma GCC unroll 32
    for (int l = 0; l < Count; ++l) sum[l] += kernel[d] * (a[l] + b[l]);
  }
#pragma GCC unroll 32
  for (int l = 0; l < Count; ++l) out[l] = sum[l];
}

/// Convolves `width` values; `out` does not overlap the input. The last values may be computed twice.
void convolve_row(const float* centre, int step, std::span<const float> kernel, float* out, int width) {
  constexpr int kLanes = 32, kFewLanes = 8;
  const auto convolve_by = [&]<int Count>(std::integral_constant<int, Count>) {
    for (int i = 0; i < width; i += Count) {
      const int at = std::min(i, width - Count);
      convolve<Count>(centre + at, step, kernel, out + at);
    }
  };
  if (width >= kLanes)
    convolve_by(std::integral_constant<int, kLanes>{});
  else if (width >= kFewLanes)
    convolve_by(std::integral_constant<int, kFewLanes>{});
  else
    convolve_by(std::integral_constant<int, 1>{});
}

}  // namespace

void smooth(std::vector<float>& values, const BoxGrid& grid, const std::array<double, 3>& sigma, const RunJobs& run) {
  const auto [ni, nj, nk] = grid.size;
  for (int axis = 0; axis < 3; ++axis) {
    const double s = sigma[axis];
    const int n = grid.size[axis];
    if (s < 0.2 || n == 1) continue;
    const int radius = std::max(1, static_cast<int>(std::ceil(3 * s)));
    std::vector<float> kernel(radius + 1);
    double sum = 0;
    for (int t = 0; t <= radius; ++t)
      sum += (t == 0 ? 1 : 2) * (kernel[t] = static_cast<float>(std::exp(-t * t / (2 * s * s))));
    for (float& k : kernel) k = static_cast<float>(k / sum);
    // A job smooths a plane: along i row by row, along j and k all cells of a row at once.
    const bool by_line = axis == 0;
    const int width = by_line ? 1 : ni, stride = grid.stride(axis);
    run(axis == 2 ? nj : nk, [&, ni = ni, nj = nj](int job) {
      std::vector<float> padded(std::size_t(n + 2 * radius) * width);
      float* const centre = padded.data() + std::size_t(radius) * width;
      const auto pad = [&] {
        for (int t = 1; t <= radius; ++t) {
          std::copy_n(centre, width, centre - std::ptrdiff_t(t) * width);
          std::copy_n(centre + std::ptrdiff_t(n - 1) * width, width, centre + std::ptrdiff_t(n - 1 + t) * width);
        }
      };
      float* const plane = values.data() + std::size_t(job) * (axis == 2 ? ni : grid.plane());
      if (by_line) {
        for (int j = 0; j < nj; ++j) {
          float* const line = plane + std::size_t(j) * ni;
          std::copy_n(line, n, centre);
          pad();
          convolve_row(centre, 1, kernel, line, n);
        }
        return;
      }
      for (int t = 0; t < n; ++t) std::copy_n(plane + std::size_t(t) * stride, ni, centre + std::size_t(t) * ni);
      pad();
      for (int t = 0; t < n; ++t)
        convolve_row(centre + std::size_t(t) * ni, ni, kernel, plane + std::size_t(t) * stride, ni);
    });
  }
}

void smooth_by_least_spacing(std::vector<float>& values, const BoxGrid& grid, const std::array<double, 3>& spacing_mm,
                             double voxels, const RunJobs& run) {
  const double mm = voxels * *std::min_element(spacing_mm.begin(), spacing_mm.end());
  smooth(values, grid, {mm / spacing_mm[0], mm / spacing_mm[1], mm / spacing_mm[2]}, run);
}

namespace {

/// Copies the voxels of a box; those that are not finite become 0.
void copy_voxels(const Volume& volume, const VoxelBox& box, BoxImage& image, const RunJobs& run) {
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    run(box.size[2], [&](int k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const T* const from = voxels.data() + volume.offset(box.first[0], box.first[1] + j, box.first[2] + k);
        const std::size_t to = box.offset(0, j, k);
        for (int i = 0; i < box.size[0]; ++i) {
          const float value = static_cast<float>(from[i]);
          const bool finite = std::isfinite(value);
          image.finite[to + i] = finite;
          image.value[to + i] = finite ? value : 0;
        }
      }
    });
  });
}

/// Range of the voxels of a volume that overlap a cell, along an axis.
struct CellVoxels {
  int first, end;
  double begin, stop;  ///< limits of the cell, voxels

  CellVoxels(int index, double cell, int size)
      : begin(index * cell), stop(std::min((index + 1) * cell, static_cast<double>(size))) {
    constexpr double kRounding = 1e-6;  // as in voxels_around()
    first = std::min(static_cast<int>(begin + kRounding), size - 1);
    end = std::clamp(static_cast<int>(std::ceil(stop - kRounding)), first + 1, size);
  }
  /// Fraction of a voxel that lies in the cell.
  float weight(int voxel) const {
    return static_cast<float>(std::max(std::min(voxel + 1.0, stop) - std::max<double>(voxel, begin), 0.0));
  }
};

/// Averages finite voxels over the cells of a box.
void average_cells(const Volume& volume, const CellSize& cell, const VoxelBox& box, BoxImage& image,
                   const RunJobs& run) {
  const std::array<int, 3>& size = volume.geometry().size;
  const VoxelBox voxels = voxels_around(box, cell, size);
  std::vector<CellVoxels> columns;
  columns.reserve(box.size[0]);
  for (int i = 0; i < box.size[0]; ++i) columns.emplace_back(box.first[0] + i, cell[0], size[0]);
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> values = volume.voxels<T>();
    run(box.size[2], [&](int k) {
      const CellVoxels planes(box.first[2] + k, cell[2], size[2]);
      std::vector<float> sum(voxels.size[0]), weight(voxels.size[0]);
      for (int j = 0; j < box.size[1]; ++j) {
        const CellVoxels rows(box.first[1] + j, cell[1], size[1]);
        std::ranges::fill(sum, 0.0f);
        std::ranges::fill(weight, 0.0f);
        float row_weight = 0;
        for (int z = planes.first; z < planes.end; ++z) {
          for (int y = rows.first; y < rows.end; ++y) {
            const T* const from = values.data() + volume.offset(voxels.first[0], y, z);
            const float w = planes.weight(z) * rows.weight(y);
            row_weight += w;
            for (int x = 0; x < voxels.size[0]; ++x) {
              const float value = static_cast<float>(from[x]);
              const bool finite = std::isfinite(value);
              sum[x] += finite ? w * value : 0.0f;
              weight[x] += finite ? w : 0.0f;
            }
          }
        }
        const std::size_t row = box.offset(0, j, k);
        for (int i = 0; i < box.size[0]; ++i) {
          float total = 0, finite = 0, all = 0;
          for (int x = columns[i].first; x < columns[i].end; ++x) {
            const float w = columns[i].weight(x);
            total += w * sum[x - voxels.first[0]];
            finite += w * weight[x - voxels.first[0]];
            all += w * row_weight;
          }
          const bool is_finite = finite > 0 && 2 * finite >= all;
          image.finite[row + i] = is_finite;
          image.value[row + i] = is_finite ? total / finite : 0;
        }
      }
    });
  });
}

}  // namespace

BoxImage extract_intensities(const Volume& volume, const CellSize& cell, const VoxelBox& box, const RunJobs& run) {
  BoxImage image{{box.size}, {}, {}};
  const int n = image.grid.count();
  image.value.resize(n);
  image.finite.resize(n);
  if (cell == kVoxelCells)
    copy_voxels(volume, box, image, run);
  else
    average_cells(volume, cell, box, image, run);
  return image;
}

BoxImage extract_box(const Volume& volume, const CellSize& cell, const VoxelBox& box, const RunJobs& run) {
  BoxImage image = extract_intensities(volume, cell, box, run);
  const int n = image.grid.count();
  // Percentiles of every step-th cell.
  std::vector<float> sample;
  const int step = std::max(1, n / 200000) | 1;
  for (int v = 0; v < n; v += step)
    if (image.finite[v]) sample.push_back(image.value[v]);
  float low = 0, high = 1;
  if (!sample.empty()) low = quantile(sample, 0.01), high = quantile(sample, 0.99);
  // A power of two, which changes no bit of ordinary intensities: range and inverse range must not overflow.
  const float unit = !std::isfinite(high - low) ? 0.25f : high - low < 0x1p-120f ? 0x1p100f : 1.0f;
  low *= unit, high *= unit;
  const float scale = high > low ? 1 / (high - low) : 0;
  for_each_index(run, n, [value = image.value.data(), finite = image.finite.data(), unit, low, scale](int v) {
    value[v] = finite[v] ? std::min(std::max((value[v] * unit - low) * scale, 0.0f), 1.0f) : 0.0f;
  });
  return image;
}

void fill_with_mean(BoxImage& image) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < image.value.size(); ++v)
    if (image.finite[v]) sum += image.value[v], ++count;
  if (count == image.value.size() || count == 0) return;
  const auto mean = static_cast<float>(sum / static_cast<double>(count));
  for (std::size_t v = 0; v < image.value.size(); ++v)
    if (!image.finite[v]) image.value[v] = mean;
}

std::vector<std::uint8_t> cells_in_range(const Volume& volume, const CellSize& cell, const VoxelBox& box,
                                         const IntensityRange& range, const std::array<double, 3>& spacing_mm,
                                         double smoothing, const RunJobs& run) {
  BoxImage image = extract_intensities(volume, cell, box, run);
  const auto least = static_cast<float>(std::min(std::max(0.0, range.low), range.high));
  for_each_index(run, image.grid.count(), [value = image.value.data(), finite = image.finite.data(), least](int v) {
    if (!finite[v]) value[v] = least;
  });
  smooth_by_least_spacing(image.value, image.grid, spacing_mm, smoothing, run);
  std::vector<std::uint8_t>& in_range = image.finite;
  for_each_index(run, image.grid.count(), [value = image.value.data(), to = in_range.data(), range](int v) {
    to[v] = to[v] && range.contains(value[v]);
  });
  return std::move(in_range);
}

}  // namespace simplexseg
