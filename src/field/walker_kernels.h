// SPDX-License-Identifier: Apache-2.0
// Kernels of the random walker (parallel/walker.h).
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/vec3.h"
#include "field/box_grid.h"
#include "field/parallel/executor.h"

namespace simplexseg {

inline constexpr int kCoarsestVoxels = 64;  ///< largest coarsest level

/// Level of the multigrid cycle.
struct WalkerLevelShape {
  BoxGrid grid;
  std::array<bool, 3> halved{};  ///< axes along which the next level has half the cells
};
/// Levels of a grid, finest first, by semicoarsening: the next level halves the axes with strong coupling.
std::vector<WalkerLevelShape> walker_levels(const BoxGrid& grid, const std::array<double, 3>& spacing_mm);

/// System of a level in the memory of an executor.
struct LevelView {
  int row, plane;
  const float *g_i, *g_j, *g_k;  ///< conductances to the next cell along each axis
  const float* inverse_diagonal;

  /// Sum of the conductances of cell v.
  SIMPLEXSEG_HD float degree(int v) const {
    return g_i[v] + g_i[v - 1] + g_j[v] + g_j[v - row] + g_k[v] + g_k[v - plane];
  }
  /// Sum of conductance times x over the six neighbours of cell v.
  SIMPLEXSEG_HD float neighbour_sum(const float* x, int v) const { return neighbour_sum(x, v, 1, 1, row, row); }
  /// Sum with the offsets of the neighbours along i and j, 0 for a neighbour that does not exist.
  SIMPLEXSEG_HD float neighbour_sum(const float* x, int v, int left, int right, int below, int above) const {
    return g_i[v] * x[v + right] + g_i[v - 1] * x[v - left] + g_j[v] * x[v + above] + g_j[v - row] * x[v - below] +
           g_k[v] * x[v + plane] + g_k[v - plane] * x[v - plane];
  }
};

/// Residual of the start; 0 where the field is fixed.
struct StartResidual {
  LevelView level;
  const float *field, *prior_weight;
  const std::uint8_t *target, *fixed;
  float* residual;

  SIMPLEXSEG_HD void operator()(int v) const {
    const float x = field[v], degree = level.degree(v);
    const float r = level.neighbour_sum(field, v) - degree * x + prior_weight[v] * (target[v] * (1.0f / 255) - x);
    residual[v] = fixed[v] ? 0.0f : r;
  }
};

/// Adds the conductances to fixed (Dirichlet) neighbours to the excess, 0 in fixed cells.
struct AddFixedToDiagonal {
  LevelView level;
  const std::uint8_t* fixed;  ///< padded
  float* excess;

  SIMPLEXSEG_HD void operator()(int v) const {
    const int row = level.row, plane = level.plane;
    const float to_fixed = (fixed[v + 1] ? level.g_i[v] : 0) + (fixed[v - 1] ? level.g_i[v - 1] : 0) +
                           (fixed[v + row] ? level.g_j[v] : 0) + (fixed[v - row] ? level.g_j[v - row] : 0) +
                           (fixed[v + plane] ? level.g_k[v] : 0) + (fixed[v - plane] ? level.g_k[v - plane] : 0);
    excess[v] = fixed[v] ? 0.0f : excess[v] + to_fixed;
  }
};

/// Removes the conductances of fixed cells.
struct CutFixedEdges {
  const std::uint8_t* fixed;
  float* conductance[3];
  int stride[3];
  SIMPLEXSEG_HD void operator()(int v) const {
    for (int a = 0; a < 3; ++a) conductance[a][v] = fixed[v] || fixed[v + stride[a]] ? 0.0f : conductance[a][v];
  }
};

/// Inverse of the diagonal: excess plus conductances. 1 where it is 0.
struct InverseDiagonal {
  LevelView level;
  const float* excess;  ///< part of the diagonal beyond the conductances: m' of docs/mathematics.md 8.5
  float* out;
  SIMPLEXSEG_HD void operator()(int v) const {
    const float d = excess[v] + level.g_i[v] + level.g_i[v - 1] + level.g_j[v] + level.g_j[v - level.row] +
                    level.g_k[v] + level.g_k[v - level.plane];
    out[v] = d > 0 ? 1.0f / d : 1.0f;
  }
};

/// Writes A times the direction of conjugate gradients; returns the contribution of v to its product with the
/// direction.
struct ApplyOperator {
  LevelView level;
  const float* direction;
  float* to;
  SIMPLEXSEG_HD Contribution operator()(int v) const {
    const float product = direction[v] / level.inverse_diagonal[v] - level.neighbour_sum(direction, v);
    to[v] = product;
    return {product * direction[v], 0};
  }
};

/// Step of conjugate gradients along the direction. `product`: A times the direction.
struct StepAlongDirection {
  float step;
  const float *direction, *product;
  float *iterate, *residual;
  SIMPLEXSEG_HD void operator()(int v) const {
    iterate[v] += step * direction[v];
    residual[v] -= step * product[v];
  }
};

/// Next direction of conjugate gradients. `ratio`: product of residual and correction per that of the step before.
struct NewDirection {
  float ratio;
  const float* correction;
  float* direction;
  SIMPLEXSEG_HD void operator()(int v) const { direction[v] = correction[v] + ratio * direction[v]; }
};

/// Conductance between a voxel and the next one along an axis; 0 beside a voxel that is not finite. `scale`: (smallest
/// spacing / spacing)^2.
struct Conductance {
  const float* image;
  const std::uint8_t* finite;  ///< null: all are finite
  float scale, minus_beta;
  int stride;

  SIMPLEXSEG_HD float operator()(int v) const {
    constexpr float least = 1e-5f;  // keeps all finite voxels connected
    const float d = image[v + stride] - image[v];
    const float g = scale * (std::exp(minus_beta * d * d) + least);
    return !finite || (finite[v] && finite[v + stride]) ? g : 0.0f;
  }
};

/// Weight of the prior. It is proportional to the conductances, so that neighbours outweigh the prior at edges, where
/// cells contain both sides.
struct PriorWeights {
  LevelView level;
  float sixth;  ///< 1/6 of the weight in mean conductances
  float* prior_weight;
  SIMPLEXSEG_HD void operator()(int v) const { prior_weight[v] = sixth * level.degree(v); }
};

}  // namespace simplexseg
