// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "field/parallel/executor.h"

namespace simplexseg {

inline constexpr int kMostReach = 31;  ///< voxels of a Gaussian, to one side

/// A Gaussian along one axis of several fields on the same grid; beyond its ends a line goes on as it ends.
template <int kFields>
struct SmoothAlong {
  const float* from[kFields];
  float* to[kFields];
  int axis, length, stride;  ///< of a line along the axis; between its voxels
  int reach;
  float weight[kMostReach + 1];

  /// Cells i ... i + kLanes - 1 of row (j, k).
  template <int kLanes>
  SIMPLEXSEG_HD void run(const CellAt& cell) const {
    const int at = axis == 0 ? cell.i : axis == 1 ? cell.j : cell.k, v = cell.v, first = v - at * stride;
    const auto before = [&](int d) { return first + (at > d ? at - d : 0) * stride; };
    const auto after = [&](int d) { return first + (at + d < length ? at + d : length - 1) * stride; };
    if constexpr (kLanes == 1) {
      float sum[kFields];
      for (int f = 0; f < kFields; ++f) sum[f] = weight[0] * from[f][v];
      for (int d = 1; d <= reach; ++d) {
        const int a = before(d), b = after(d);
        for (int f = 0; f < kFields; ++f) sum[f] += weight[d] * (from[f][a] + from[f][b]);
      }
      for (int f = 0; f < kFields; ++f) to[f][v] = sum[f];
    } else if (axis == 0) {
      float line[kLanes + 2 * kMostReach];
      for (int f = 0; f < kFields; ++f) {
        for (int t = 0; t < kLanes + 2 * reach; ++t)
          line[t] = from[f][first + smaller(larger(at - reach + t, 0), length - 1)];
        const float* const centre = line + reach;
        weigh<kLanes>(
            centre, [=](int d) { return centre - d; }, [=](int d) { return centre + d; }, to[f] + v);
      }
    } else {
      for (int f = 0; f < kFields; ++f)
        weigh<kLanes>(
            from[f] + v, [&](int d) { return from[f] + before(d); }, [&](int d) { return from[f] + after(d); },
            to[f] + v);
    }
  }

 private:
  /// Unrolled, so that the sums are vector registers.
  template <int kLanes, class Before, class After>
  SIMPLEXSEG_HD void weigh(const float* centre, const Before& before, const After& after, float* out) const {
    float sum[kLanes];
    SIMPLEXSEG_UNROLL_LANES
    for (int l = 0; l < kLanes; ++l) sum[l] = weight[0] * centre[l];
    for (int d = 1; d <= reach; ++d) {
      const float *const a = before(d), *const b = after(d);
      SIMPLEXSEG_UNROLL_LANES
      for (int l = 0; l < kLanes; ++l) sum[l] += weight[d] * (a[l] + b[l]);
    }
    SIMPLEXSEG_UNROLL_LANES
    for (int l = 0; l < kLanes; ++l) out[l] = sum[l];
  }
};

/// Fields on an executor, one after the other, and room for as many again.
template <class Executor, int kFields>
class SmoothedFields {
 public:
  SmoothedFields(const Executor& executor, const BoxGrid& grid)
      : executor_(executor), grid_(grid), memory_(executor.template array<float>(2 * std::size_t(kFields) * room())) {
    for (int f = 0; f < kFields; ++f) {
      fields_[f] = memory_.data() + f * room();
      others_[f] = memory_.data() + (kFields + f) * room();
    }
  }
  float* data(int field) { return fields_[field]; }
  /// smooth() of field/box_image.h, of all of them.
  void smooth(const std::array<double, 3>& sigma) {
    for (int axis = 0; axis < 3; ++axis) {
      const double s = sigma[axis];
      const int n = grid_.size[axis];
      if (s < 0.2 || n == 1) continue;
      SmoothAlong<kFields> along{};
      along.axis = axis, along.length = n, along.stride = grid_.stride(axis);
      along.reach = std::min(std::max(1, static_cast<int>(std::ceil(3 * s))), kMostReach);
      double sum = 0;
      for (int t = 0; t <= along.reach; ++t)
        sum += (t == 0 ? 1 : 2) * (along.weight[t] = static_cast<float>(std::exp(-t * t / (2 * s * s))));
      for (int t = 0; t <= along.reach; ++t) along.weight[t] = static_cast<float>(along.weight[t] / sum);
      for (int f = 0; f < kFields; ++f) along.from[f] = fields_[f], along.to[f] = others_[f];
      executor_.each_cell_lanes(grid_, along);
      std::swap(fields_, others_);
    }
  }
  /// smooth_by_least_spacing() of field/box_image.h.
  void smooth_by_least_spacing(const std::array<double, 3>& spacing_mm, double voxels) {
    const double mm = voxels * *std::min_element(spacing_mm.begin(), spacing_mm.end());
    smooth({mm / spacing_mm[0], mm / spacing_mm[1], mm / spacing_mm[2]});
  }
  std::size_t bytes() const { return memory_.bytes(); }

 private:
  /// Of a field: aligned as transactions of a device's memory are.
  std::size_t room() const { return (std::size_t(grid_.count()) + 31) / 32 * 32; }

  const Executor& executor_;
  BoxGrid grid_;
  typename Executor::template Array<float> memory_;
  std::array<float*, kFields> fields_, others_;
};

}  // namespace simplexseg
