// SPDX-License-Identifier: Apache-2.0
// Kernels of the random walker (parallel/walker.h).
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/vec3.h"
#include "field/box_grid.h"

namespace simplexseg {

inline constexpr int kCoarsestVoxels = 64;

/// A level of the walker's multigrid cycle.
struct WalkerLevelShape {
  BoxGrid grid;
  std::array<bool, 3> halved{};  ///< axes along which the next level has half the voxels
};
/// Boxes of two voxels along each axis that couples strongly, down to kCoarsestVoxels.
std::vector<WalkerLevelShape> walker_levels(const BoxGrid& grid, const std::array<double, 3>& spacing_mm);

/// Pointers into one level: what a kernel sees.
struct LevelView {
  int row, plane;
  const float *wx, *wy, *wz, *inverse_diagonal;

  /// The sum of weight times value over the six neighbours.
  SIMPLEXSEG_HD float flow(const float* x, int v) const { return flow(x, v, 1, 1, row, row); }
  /// With how far the values of the neighbours along i and j lie away, down and up: 0 where there is none.
  SIMPLEXSEG_HD float flow(const float* x, int v, int left, int right, int below, int above) const {
    return wx[v] * x[v + right] + wx[v - 1] * x[v - left] + wy[v] * x[v + above] + wy[v - row] * x[v - below] +
           wz[v] * x[v + plane] + wz[v - plane] * x[v - plane];
  }
};

/// Residual of the start; zero where the field is held.
struct StartResidual {
  LevelView level;
  const float *x, *pull;
  const std::uint8_t *target, *held;
  float* residual;

  SIMPLEXSEG_HD void operator()(int v) const {
    const float weights =
        level.wx[v] + level.wx[v - 1] + level.wy[v] + level.wy[v - level.row] + level.wz[v] + level.wz[v - level.plane];
    const float r = level.flow(x, v) - weights * x[v] + pull[v] * (target[v] * (1.0f / 255) - x[v]);
    residual[v] = held[v] ? 0.0f : r;
  }
};

/// What a free voxel is drawn by, its held neighbours counted in, goes into the mass.
struct HeldIntoMass {
  LevelView level;
  const std::uint8_t* held;  ///< padded
  float* mass;

  SIMPLEXSEG_HD void operator()(int v) const {
    const int r = level.row, p = level.plane;
    const float to_held = (held[v + 1] ? level.wx[v] : 0) + (held[v - 1] ? level.wx[v - 1] : 0) +
                          (held[v + r] ? level.wy[v] : 0) + (held[v - r] ? level.wy[v - r] : 0) +
                          (held[v + p] ? level.wz[v] : 0) + (held[v - p] ? level.wz[v - p] : 0);
    mass[v] = held[v] ? 0.0f : mass[v] + to_held;
  }
};

struct CutHeldEdges {
  const std::uint8_t* held;
  float* weight;
  int stride;
  SIMPLEXSEG_HD void operator()(int v) const { weight[v] = held[v] || held[v + stride] ? 0.0f : weight[v]; }
};

struct InverseDiagonal {
  LevelView level;
  const float* mass;
  float* out;
  SIMPLEXSEG_HD void operator()(int v) const {
    const float d = mass[v] + level.wx[v] + level.wx[v - 1] + level.wy[v] + level.wy[v - level.row] + level.wz[v] +
                    level.wz[v - level.plane];
    out[v] = d > 0 ? 1.0f / d : 1.0f;
  }
};

/// A p, and its product with p.
struct Apply {
  LevelView level;
  const float* p;
  float* out;
  SIMPLEXSEG_HD float operator()(int v) const {
    const float a = p[v] / level.inverse_diagonal[v] - level.flow(p, v);
    out[v] = a;
    return a * p[v];
  }
};

struct Advance {
  float step;
  const float *p, *ap;
  float *x, *r;
  SIMPLEXSEG_HD void operator()(int v) const {
    x[v] += step * p[v];
    r[v] -= step * ap[v];
  }
};

struct Product {
  const float *a, *b;
  SIMPLEXSEG_HD float operator()(int v) const { return a[v] * b[v]; }
};

struct NewDirection {
  float share;
  const float* z;
  float* p;
  SIMPLEXSEG_HD void operator()(int v) const { p[v] = z[v] + share * p[v]; }
};

/// Conductance between a voxel and the next one along an axis, 0 beside what is not finite; `scale`: (least spacing /
/// spacing)^2, `fall`: -beta.
struct Conductance {
  const float* value;
  const std::uint8_t* finite;  ///< or null: all are
  float scale, fall;
  int stride;

  SIMPLEXSEG_HD float operator()(int v) const {
    constexpr float least = 1e-5f;  // keeps every finite voxel connected
    const float d = value[v + stride] - value[v];
    const float w = scale * (std::exp(fall * d * d) + least);
    return !finite || (finite[v] && finite[v + stride]) ? w : 0.0f;
  }
};

/// The pull towards the prior. In proportion to the mean conductance: on an edge, which conducts little, the neighbours
/// still say more than the prior, which knows nothing of what lies half on either side.
struct PullOfEdges {
  LevelView level;
  float sixth;  ///< of the pull, in mean conductances
  float* pull;
  SIMPLEXSEG_HD void operator()(int v) const {
    const int row = level.row, plane = level.plane;
    pull[v] =
        sixth * (level.wx[v] + level.wx[v - 1] + level.wy[v] + level.wy[v - row] + level.wz[v] + level.wz[v - plane]);
  }
};

}  // namespace simplexseg
