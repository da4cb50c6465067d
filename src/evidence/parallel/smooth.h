// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "evidence/parallel/executor.h"

namespace simplexseg {

inline constexpr int kMostReach = 31;  ///< voxels of a Gaussian, to one side

/// A Gaussian along one axis of several fields on the same grid; beyond its ends a line goes on as it ends.
template <int kFields>
struct SmoothAlong {
  const float* from[kFields];
  float* to[kFields];
  int length, stride;  ///< of a line along the axis; between its voxels
  int reach;
  float weight[kMostReach + 1];

  SIMPLEXSEG_HD void operator()(int v) const {
    const int at = v / stride % length, first = v - at * stride;
    float sum[kFields];
    for (int f = 0; f < kFields; ++f) sum[f] = weight[0] * from[f][v];
    for (int d = 1; d <= reach; ++d) {
      const int a = first + (at > d ? at - d : 0) * stride,
                b = first + (at + d < length ? at + d : length - 1) * stride;
      for (int f = 0; f < kFields; ++f) sum[f] += weight[d] * (from[f][a] + from[f][b]);
    }
    for (int f = 0; f < kFields; ++f) to[f][v] = sum[f];
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
  /// smooth() of evidence/box_image.h, of all of them.
  void smooth(const std::array<double, 3>& sigma) {
    for (int axis = 0; axis < 3; ++axis) {
      const double s = sigma[axis];
      const int n = grid_.size[axis];
      if (s < 0.2 || n == 1) continue;
      SmoothAlong<kFields> along{};
      along.length = n, along.stride = grid_.stride(axis);
      along.reach = std::min(std::max(1, static_cast<int>(std::ceil(3 * s))), kMostReach);
      double sum = 0;
      for (int t = 0; t <= along.reach; ++t)
        sum += (t == 0 ? 1 : 2) * (along.weight[t] = static_cast<float>(std::exp(-t * t / (2 * s * s))));
      for (int t = 0; t <= along.reach; ++t) along.weight[t] = static_cast<float>(along.weight[t] / sum);
      for (int f = 0; f < kFields; ++f) along.from[f] = fields_[f], along.to[f] = others_[f];
      executor_.each(grid_.count(), along);
      std::swap(fields_, others_);
    }
  }
  /// smooth_by_least_spacing() of evidence/box_image.h.
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
