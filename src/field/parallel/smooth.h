// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "field/parallel/executor.h"

namespace simplexseg {

inline constexpr int kMostRadius = 31;  ///< largest truncation radius of a Gaussian, cells

/// Convolution of several fields of a grid with a Gaussian along one axis; values beyond the border repeat the
/// outermost.
template <int kFields>
struct SmoothAlong {
  const float* from[kFields];
  float* to[kFields];
  int axis, length, stride;  ///< of a line along the axis, and between its cells
  int radius;
  float weight[kMostRadius + 1];

  /// Cells i ... i + kLanes - 1 of row (j, k).
  template <int kLanes>
  SIMPLEXSEG_HD void run(const CellAt& cell) const {
    const int at = axis == 0 ? cell.i : axis == 1 ? cell.j : cell.k, v = cell.v, first = v - at * stride;
    const auto before = [&](int d) { return first + (at > d ? at - d : 0) * stride; };
    const auto after = [&](int d) { return first + (at + d < length ? at + d : length - 1) * stride; };
    if constexpr (kLanes == 1) {
      float sum[kFields];
      for (int f = 0; f < kFields; ++f) sum[f] = weight[0] * from[f][v];
      for (int d = 1; d <= radius; ++d) {
        const int a = before(d), b = after(d);
        for (int f = 0; f < kFields; ++f) sum[f] += weight[d] * (from[f][a] + from[f][b]);
      }
      for (int f = 0; f < kFields; ++f) to[f][v] = sum[f];
    } else if (axis == 0) {
      float line[kLanes + 2 * kMostRadius];
      for (int f = 0; f < kFields; ++f) {
        for (int t = 0; t < kLanes + 2 * radius; ++t)
          line[t] = from[f][first + smaller(larger(at - radius + t, 0), length - 1)];
        const float* const centre = line + radius;
        convolve<kLanes>(
            centre, [=](int d) { return centre - d; }, [=](int d) { return centre + d; }, to[f] + v);
      }
    } else {
      for (int f = 0; f < kFields; ++f)
        convolve<kLanes>(
            from[f] + v, [&](int d) { return from[f] + before(d); }, [&](int d) { return from[f] + after(d); },
            to[f] + v);
    }
  }

 private:
  /// Convolves kLanes values; unrolled, so that the sums are vector registers.
  template <int kLanes, class Before, class After>
  SIMPLEXSEG_HD void convolve(const float* centre, const Before& before, const After& after, float* out) const {
    float sum[kLanes];
    SIMPLEXSEG_UNROLL_LANES
    for (int l = 0; l < kLanes; ++l) sum[l] = weight[0] * centre[l];
    for (int d = 1; d <= radius; ++d) {
      const float *const a = before(d), *const b = after(d);
      SIMPLEXSEG_UNROLL_LANES
      for (int l = 0; l < kLanes; ++l) sum[l] += weight[d] * (a[l] + b[l]);
    }
    SIMPLEXSEG_UNROLL_LANES
    for (int l = 0; l < kLanes; ++l) out[l] = sum[l];
  }
};

/// Fields on an executor that are smoothed together, in an array that also contains the workspace.
template <class Executor, int kFields>
class SmoothedFields {
 public:
  SmoothedFields(const Executor& executor, const BoxGrid& grid)
      : executor_(executor), grid_(grid), memory_(executor.template array<float>(2 * std::size_t(kFields) * stride())) {
    for (int f = 0; f < kFields; ++f) {
      fields_[f] = memory_.data() + f * stride();
      others_[f] = memory_.data() + (kFields + f) * stride();
    }
  }
  float* data(int field) { return fields_[field]; }
  /// Smooths all fields as smooth() of field/box_image.h.
  void smooth(const std::array<double, 3>& sigma) {
    for (int axis = 0; axis < 3; ++axis) {
      const double s = sigma[axis];
      const int n = grid_.size[axis];
      if (s < 0.2 || n == 1) continue;
      SmoothAlong<kFields> along{};
      along.axis = axis, along.length = n, along.stride = grid_.stride(axis);
      along.radius = std::min(std::max(1, static_cast<int>(std::ceil(3 * s))), kMostRadius);
      double sum = 0;
      for (int t = 0; t <= along.radius; ++t)
        sum += (t == 0 ? 1 : 2) * (along.weight[t] = static_cast<float>(std::exp(-t * t / (2 * s * s))));
      for (int t = 0; t <= along.radius; ++t) along.weight[t] = static_cast<float>(along.weight[t] / sum);
      for (int f = 0; f < kFields; ++f) along.from[f] = fields_[f], along.to[f] = others_[f];
      executor_.each_cell_lanes(grid_, along);
      std::swap(fields_, others_);
    }
  }
  /// Smooths all fields as smooth_by_least_spacing() of field/box_image.h.
  void smooth_by_least_spacing(const std::array<double, 3>& spacing_mm, double voxels) {
    const double mm = voxels * *std::min_element(spacing_mm.begin(), spacing_mm.end());
    smooth({mm / spacing_mm[0], mm / spacing_mm[1], mm / spacing_mm[2]});
  }
  std::size_t bytes() const { return memory_.bytes(); }

 private:
  /// Distance between fields in the array, aligned to memory transactions of a device.
  std::size_t stride() const { return (std::size_t(grid_.count()) + 31) / 32 * 32; }

  const Executor& executor_;
  BoxGrid grid_;
  typename Executor::template Array<float> memory_;
  std::array<float*, kFields> fields_, others_;
};

}  // namespace simplexseg
