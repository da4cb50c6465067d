// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "evidence/parallel/executor.h"

namespace simplexseg {

inline constexpr int kMostReach = 31;  ///< voxels of a Gaussian, to one side

/// A Gaussian along one axis of a grid.
struct GaussianAlong {
  int length, stride;  ///< of a line along the axis; between its voxels
  int reach;
  float weight[kMostReach + 1];
};
/// Along those axes of a grid along which it is felt.
struct Gaussian {
  int count;
  GaussianAlong along[3];
};

/// The one of smooth() (evidence/box_image.h); sigma in voxels.
inline Gaussian gaussian(const BoxGrid& grid, const std::array<double, 3>& sigma) {
  Gaussian all{};
  for (int axis = 0; axis < 3; ++axis) {
    const double s = sigma[axis];
    if (s < 0.2 || grid.size[axis] == 1) continue;
    GaussianAlong& along = all.along[all.count++];
    along.length = grid.size[axis], along.stride = grid.stride(axis);
    along.reach = std::min(std::max(1, static_cast<int>(std::ceil(3 * s))), kMostReach);
    double sum = 0;
    for (int t = 0; t <= along.reach; ++t)
      sum += (t == 0 ? 1 : 2) * (along.weight[t] = static_cast<float>(std::exp(-t * t / (2 * s * s))));
    for (int t = 0; t <= along.reach; ++t) along.weight[t] = static_cast<float>(along.weight[t] / sum);
  }
  return all;
}
/// The one of smooth_by_least_spacing().
inline Gaussian gaussian_by_least_spacing(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, double voxels) {
  const double mm = voxels * *std::min_element(spacing_mm.begin(), spacing_mm.end());
  return gaussian(grid, {mm / spacing_mm[0], mm / spacing_mm[1], mm / spacing_mm[2]});
}

/// Several fields on the same grid along one axis; beyond its ends a line goes on as it ends.
template <int kFields>
struct SmoothAlong {
  const GaussianAlong& along;
  float* const (&from)[kFields];
  float* const (&to)[kFields];

  SIMPLEXSEG_HD void operator()(int v) const {
    const int stride = along.stride, length = along.length, at = v / stride % length, first = v - at * stride;
    float sum[kFields];
    for (int f = 0; f < kFields; ++f) sum[f] = along.weight[0] * from[f][v];
    for (int d = 1; d <= along.reach; ++d) {
      const int a = first + (at > d ? at - d : 0) * stride,
                b = first + (at + d < length ? at + d : length - 1) * stride;
      for (int f = 0; f < kFields; ++f) sum[f] += along.weight[d] * (from[f][a] + from[f][b]);
    }
    for (int f = 0; f < kFields; ++f) to[f][v] = sum[f];
  }
};

/// smooth() (evidence/box_image.h) of fields of n voxels by a team of all threads. Fields and the spare ones, room for
/// as many, change places with every axis.
template <int kFields, class All>
SIMPLEXSEG_HD void smooth_fields(const All& all, int n, const Gaussian& gaussian, float* (&fields)[kFields],
                                 float* (&spare)[kFields]) {
  for (int axis = 0; axis < gaussian.count; ++axis) {
    all.each(n, SmoothAlong<kFields>{gaussian.along[axis], fields, spare});
    for (int f = 0; f < kFields; ++f) {
      float* const smoothed = spare[f];
      spare[f] = fields[f];
      fields[f] = smoothed;
    }
  }
}

}  // namespace simplexseg
