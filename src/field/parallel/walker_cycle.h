// SPDX-License-Identifier: Apache-2.0
// Kernels of the solver of the random walker (walker.h): a multigrid V-cycle in four passes per level. The first half
// of a red-black Gauss-Seidel sweep from zero gives r / d, so the sweep of the second colour computes that from r. The
// residual of the first colour is then the neighbour sum of the second one, and only the next sweep of the second
// colour needs the coarse correction of the first.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "field/parallel/executor.h"
#include "field/walker_kernels.h"

namespace simplexseg {

inline constexpr int kMaxLevels = 12;
inline constexpr int kCoarsestSweeps = 3;  ///< before and after the middle sweep; more do not reduce the iterations

/// Arrays of a level in the memory of an executor.
struct LevelPointers {
  LevelView edges;
  BoxGrid grid;
  int shift[3];  ///< 1 along an axis along which the next level has half the cells, else 0
  float *excess, *inverse_diagonal, *correction, *residual;

  SIMPLEXSEG_HD int count() const { return grid.count(); }
  /// Sum of conductance times value(u) over the six neighbours u. Beyond the box, where conductances are 0, value(u) of
  /// any cell within one plane of v is evaluated.
  template <class Value>
  SIMPLEXSEG_HD float neighbour_sum(int v, const Value& value) const {
    const int row = edges.row, plane = edges.plane;
    return edges.g_i[v] * value(v + 1) + edges.g_i[v - 1] * value(v - 1) + edges.g_j[v] * value(v + row) +
           edges.g_j[v - row] * value(v - row) + edges.g_k[v] * value(v + plane) +
           edges.g_k[v - plane] * value(v - plane);
  }
};

/// Residual, diagonal and iterate of the start.
struct StartOfSolution {
  StartResidual residual;
  AddFixedToDiagonal excess;
  const float* field;
  float* iterate;
  SIMPLEXSEG_HD void operator()(int v) const {
    residual(v);
    excess(v);
    iterate[v] = field[v];
  }
};

struct AllConductances {
  Conductance along[3];
  float* conductance[3];
  BoxGrid grid;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    conductance[0][at.v] = at.i + 1 < grid.size[0] ? along[0](at.v) : 0.0f;
    conductance[1][at.v] = at.j + 1 < grid.size[1] ? along[1](at.v) : 0.0f;
    conductance[2][at.v] = at.k + 1 < grid.size[2] ? along[2](at.v) : 0.0f;
  }
};

/// Coarse operator (Galerkin product): sums of the excess within a coarse cell and of the conductances between two.
struct Coarsen {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(int to) const {
    const CellAt at = cell_at(coarse.grid, to);
    const int first[3]{at.i << fine.shift[0], at.j << fine.shift[1], at.k << fine.shift[2]};
    int last[3];
    for (int a = 0; a < 3; ++a) last[a] = smaller(first[a] + (1 << fine.shift[a]), fine.grid.size[a]) - 1;
    float excess = 0, g_i = 0, g_j = 0, g_k = 0;
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) {
          const int v = (z * fine.grid.size[1] + y) * fine.grid.size[0] + x;
          excess += fine.excess[v];
          if (x == last[0]) g_i += fine.edges.g_i[v];
          if (y == last[1]) g_j += fine.edges.g_j[v];
          if (z == last[2]) g_k += fine.edges.g_k[v];
        }
    coarse.excess[to] = excess;
    const_cast<float*>(coarse.edges.g_i)[to] = g_i;
    const_cast<float*>(coarse.edges.g_j)[to] = g_j;
    const_cast<float*>(coarse.edges.g_k)[to] = g_k;
  }
};

/// Sweeps of both colours from zero; writes the second.
struct FirstSweep {
  LevelPointers level;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const float *const r = level.residual, *const inverse = level.inverse_diagonal;
    const float sum = level.neighbour_sum(at.v, [=](int u) { return r[u] * inverse[u]; });
    level.correction[at.v] = (r[at.v] + sum) * inverse[at.v];
  }
};

/// Restriction of the residual, which is 0 in the second colour: sums within a coarse cell.
struct RestrictResidual {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const float* const z = fine.correction;
    const BoxGrid& grid = fine.grid;
    const int i0 = at.i << fine.shift[0], j0 = at.j << fine.shift[1], k0 = at.k << fine.shift[2];
    float sum = 0;
    for (int k = k0; k < smaller(k0 + (1 << fine.shift[2]), grid.size[2]); ++k)
      for (int j = j0; j < smaller(j0 + (1 << fine.shift[1]), grid.size[1]); ++j) {
        const int i = i0 + ((i0 + j + k) & 1);  // of two cells along i, one has the first colour
        if (i < smaller(i0 + (1 << fine.shift[0]), grid.size[0]))
          sum += fine.neighbour_sum((k * grid.size[1] + j) * grid.size[0] + i, [=](int u) { return z[u]; });
      }
    coarse.residual[at.v] = sum;
  }
  /// Restriction to a row of the coarse level, on the CPU.
  void row(int j, int k) const {
    const BoxGrid &grid = fine.grid, &to = coarse.grid;
    float* const out = coarse.residual + (k * to.size[1] + j) * to.size[0];
    std::fill_n(out, to.size[0], 0.0f);
    const int end_j = std::min((j + 1) << fine.shift[1], grid.size[1]),
              end_k = std::min((k + 1) << fine.shift[2], grid.size[2]);
    const LevelView level = fine.edges;
    const float* const z = fine.correction;
    for (int kf = k << fine.shift[2]; kf < end_k; ++kf)
      for (int jf = j << fine.shift[1]; jf < end_j; ++jf) {
        const int odd = (jf + kf) & 1, first = (kf * grid.size[1] + jf) * grid.size[0] + odd;
        const int count = (grid.size[0] - odd + 1) / 2;
        if (fine.shift[0] != 0) {
#pragma GCC ivdep
          for (int half = 0; half < count; ++half) out[half] += level.neighbour_sum(z, first + 2 * half);
        } else {
          for (int half = 0; half < count; ++half) out[2 * half + odd] += level.neighbour_sum(z, first + 2 * half);
        }
      }
  }
};

template <class Group>
SIMPLEXSEG_HD void restrict_residual(const Group& group, const RestrictResidual& kernel) {
  if constexpr (Group::kByRows)
    group.each_row(kernel.coarse.grid, [&](int j, int k) { kernel.row(j, k); });
  else
    each_cell(group, kernel.coarse.grid, kernel);
}

/// Prolongation and sweep of the second colour: adds the corrections of parent cells to the first colour. `kHalved`:
/// whether the next level has half the cells along i.
template <bool kHalved>
struct SweepWithParents {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const float *const r = fine.residual, *const inverse = fine.inverse_diagonal, *const parents = coarse.correction;
    const LevelView& edges = fine.edges;
    const int row = edges.row, plane = edges.plane, v = at.v;
    // Neighbours beyond the box, whose conductances are 0, are replaced by the cell itself.
    const int below = at.j > 0, above = at.j + 1 < fine.grid.size[1], under = at.k > 0,
              over = at.k + 1 < fine.grid.size[2];
    // Parents of the cell and of its neighbours along i, linear in at.half.
    const int own = kHalved ? at.half : at.i, left = kHalved ? at.half + ((at.odd - at.left) >> 1) : at.i - at.left,
              right = kHalved ? at.half + ((at.odd + at.right) >> 1) : at.i + at.right;
    const auto parent_row = [&](int j, int k) {
      return ((k >> fine.shift[2]) * coarse.grid.size[1] + (j >> fine.shift[1])) * coarse.grid.size[0];
    };
    const auto value = [=](int u, int parent) { return r[u] * inverse[u] + parents[parent]; };
    const int here = parent_row(at.j, at.k);
    const float sum = edges.g_i[v] * value(v + at.right, here + right) +
                      edges.g_i[v - 1] * value(v - at.left, here + left) +
                      edges.g_j[v] * value(v + above * row, parent_row(at.j + above, at.k) + own) +
                      edges.g_j[v - row] * value(v - below * row, parent_row(at.j - below, at.k) + own) +
                      edges.g_k[v] * value(v + over * plane, parent_row(at.j, at.k + over) + own) +
                      edges.g_k[v - plane] * value(v - under * plane, parent_row(at.j, at.k - under) + own);
    fine.correction[v] = (r[v] + sum) * inverse[v];
  }
};

/// Gauss-Seidel sweep of one colour from the values of the other.
struct Sweep {
  LevelPointers level;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    // A neighbour that does not exist, whose conductance is 0, is replaced by the cell itself: beyond the end of a row
    // there is a cell of the same colour, which another thread may be writing.
    const int below = at.j > 0 ? level.edges.row : 0, above = at.j + 1 < level.grid.size[1] ? level.edges.row : 0;
    const float sum = level.edges.neighbour_sum(level.correction, at.v, at.left, at.right, below, above);
    level.correction[at.v] = (level.residual[at.v] + sum) * level.inverse_diagonal[at.v];
  }
};

/// Residual times correction of a cell, and the magnitude of the correction.
struct CorrectionOfCell {
  const float *residual, *correction;
  SIMPLEXSEG_HD Contribution operator()(int v) const { return {residual[v] * correction[v], std::fabs(correction[v])}; }
};
/// Sweep of the first colour and CorrectionOfCell for pair t of pair_count(), two cells along i.
struct LastSweepOfPair {
  LevelPointers level;
  SIMPLEXSEG_HD Contribution operator()(int t) const {
    const BoxGrid& grid = level.grid;
    const int half = (grid.size[0] + 1) / 2, row = t / half, j = row % grid.size[1], k = row / grid.size[1];
    const int i = 2 * (t % half), first = i + ((j + k) & 1), second = i + 1 - ((j + k) & 1);
    const CorrectionOfCell of{level.residual, level.correction};
    Contribution all{0, 0};
    if (first < grid.size[0]) {
      const CellAt at = cell_at(grid, first, j, k);
      Sweep{level}(at);
      all = of(at.v);
    }
    if (second < grid.size[0]) {
      const Contribution other = of(cell_at(grid, second, j, k).v);
      all = {all.value + other.value, larger(other.magnitude, all.magnitude)};
    }
    return all;
  }
};

struct WalkerLevels {
  int count;
  int first_small_level;  ///< finest level that is processed by one block, since synchronising all threads takes longer
  LevelPointers level[kMaxLevels];
};

/// Calls kernel(v) for all 0 <= v < n by the threads of a block, and synchronises them.
template <class Block, class Kernel>
SIMPLEXSEG_HD void each_of_block(const Block& block, int n, const Kernel& kernel) {
  for (int v = block.thread; v < n; v += Block::threads) kernel(v);
  block.sync();
}
template <class Block, class Kernel>
SIMPLEXSEG_HD void each_coloured_of_block(const Block& block, const BoxGrid& grid, int colour, const Kernel& kernel) {
  if constexpr (Block::kByRows)
    each_coloured(block, grid, colour, kernel);
  else
    each_of_block(block, pair_count(grid), KernelOfColour<Kernel>{grid, colour, kernel});
}

struct BuildCoarse {
  const WalkerLevels& levels;
  template <class Block>
  SIMPLEXSEG_HD void operator()(const Block& block) const {
    for (int l = levels.first_small_level + 1; l < levels.count; ++l) {
      const LevelPointers& level = levels.level[l];
      each_of_block(block, level.count(), Coarsen{levels.level[l - 1], level});
      each_of_block(block, level.count(), InverseDiagonal{level.edges, level.excess, level.inverse_diagonal});
    }
  }
};

struct SweepsOfCoarsest {
  const LevelPointers& level;
  template <class Block>
  SIMPLEXSEG_HD void operator()(const Block& block) const {
    const auto sweep = [&](int colour) { each_coloured_of_block(block, level.grid, colour, Sweep{level}); };
    each_coloured_of_block(block, level.grid, 1, FirstSweep{level});
    for (int s = 0; s < kCoarsestSweeps; ++s) {
      sweep(0);
      sweep(1);
    }
    sweep(0);
    for (int s = 0; s < kCoarsestSweeps; ++s) {  // reverse order: the cycle is symmetric
      sweep(1);
      sweep(0);
    }
  }
};

struct CycleOfCoarse {
  const WalkerLevels& levels;
  template <class Block>
  SIMPLEXSEG_HD void operator()(const Block& block) const {
    const int first = levels.first_small_level, last = levels.count - 1;
    for (int l = first; l < last; ++l) {
      const LevelPointers &level = levels.level[l], &coarse = levels.level[l + 1];
      each_coloured_of_block(block, level.grid, 1, FirstSweep{level});
      const RestrictResidual kernel{level, coarse};
      if constexpr (Block::kByRows)
        restrict_residual(block, kernel);
      else
        each_of_block(block, coarse.count(), KernelOfCells<RestrictResidual>{coarse.grid, kernel});
    }
    block.warp(SweepsOfCoarsest{levels.level[last]});
    for (int l = last - 1; l >= first; --l) {
      const LevelPointers& level = levels.level[l];
      if (level.shift[0] != 0)
        each_coloured_of_block(block, level.grid, 1, SweepWithParents<true>{level, levels.level[l + 1]});
      else
        each_coloured_of_block(block, level.grid, 1, SweepWithParents<false>{level, levels.level[l + 1]});
      each_coloured_of_block(block, level.grid, 0, Sweep{level});
    }
  }
};

/// Solution: iterate plus the last correction, which estimates the remaining error, bounded to 0 .. 1.
struct LastCorrection {
  const float *iterate, *correction;
  const std::uint8_t* fixed;
  float* to;
  SIMPLEXSEG_HD void operator()(int v) const {
    to[v] = fixed[v] ? iterate[v] : smaller(larger(iterate[v] + correction[v], 0.0f), 1.0f);
  }
};

/// State of a solution between two calls. The correction of its residual is known.
struct WalkerState {
  double product, previous_product;  ///< of residual and correction, now and a step before
  float error;                       ///< largest correction
  int steps;                         ///< steps of conjugate gradients
  int iterations;                    ///< of the last call
};

/// Conjugate gradients with a multigrid V-cycle as the preconditioner, by all threads. Pointers are to a value for each
/// cell of the finest level.
struct SolveWalker {
  WalkerLevels levels;
  const std::uint8_t* target;
  std::uint8_t* fixed;  ///< padded
  float *field, *iterate, *direction;
  double tolerance;
  int most_iterations;
  bool resumes;
  WalkerState* state;

  template <class All>
  SIMPLEXSEG_KERNEL void operator()(const All& all) const {
    const LevelPointers& top = levels.level[0];
    const int n = top.count();
    WalkerState now{};
    float first_error = 0;
    if (resumes)
      now = *state;
    else
      begin(all);
    for (now.iterations = 0;; ++now.iterations) {
      if (!resumes || now.iterations > 0) {
        const Totals totals = cycle(all);
        now.previous_product = now.product;
        now.product = totals.sum, now.error = totals.largest;
      }
      if (now.iterations == 0) first_error = now.error;
      if (!(now.error > tolerance) || now.iterations == most_iterations || !(now.product > 0)) break;
      all.report(first_error, now.error, tolerance);
      const float ratio = now.steps == 0 ? 0.0f : static_cast<float>(now.product / now.previous_product);
      all.each(n, NewDirection{ratio, top.correction, direction});
      const double curvature = all.totals(n, ApplyOperator{top.edges, direction, top.correction}).sum;
      const float step = curvature > 0 ? static_cast<float>(now.product / curvature) : 0.0f;
      all.each(n, StepAlongDirection{step, direction, top.correction, iterate, top.residual});
      ++now.steps;
    }
    all.each(n, LastCorrection{iterate, top.correction, fixed, field});
    if (all.is_first()) *state = now;
  }

 private:
  template <class All>
  SIMPLEXSEG_HD void begin(const All& all) const {
    const LevelPointers& top = levels.level[0];
    const LevelView& v = top.edges;
    all.each(
        top.count(),
        StartOfSolution{{v, field, top.excess, target, fixed, top.residual}, {v, fixed, top.excess}, field, iterate});
    float* const conductance[3]{const_cast<float*>(v.g_i), const_cast<float*>(v.g_j), const_cast<float*>(v.g_k)};
    all.each(top.count(), CutFixedEdges{fixed, {conductance[0], conductance[1], conductance[2]}, {1, v.row, v.plane}});
    const int last = smaller(levels.first_small_level, levels.count - 1);
    for (int l = 0; l <= last; ++l) {
      const LevelPointers& level = levels.level[l];
      if (l > 0) all.each(level.count(), Coarsen{levels.level[l - 1], level});
      all.each(level.count(), InverseDiagonal{level.edges, level.excess, level.inverse_diagonal});
    }
    all.by_one_block(BuildCoarse{levels});
  }
  /// V-cycle; returns the totals of CorrectionOfCell.
  template <class All>
  SIMPLEXSEG_HD Totals cycle(const All& all) const {
    const int first_small = levels.first_small_level;
    for (int l = 0; l < first_small; ++l) {
      const LevelPointers &level = levels.level[l], &coarse = levels.level[l + 1];
      each_coloured(all, level.grid, 1, FirstSweep{level});
      restrict_residual(all, RestrictResidual{level, coarse});
    }
    all.by_one_block(CycleOfCoarse{levels});
    for (int l = first_small - 1; l >= 0; --l) {
      const LevelPointers& level = levels.level[l];
      if (level.shift[0] != 0)
        each_coloured(all, level.grid, 1, SweepWithParents<true>{level, levels.level[l + 1]});
      else
        each_coloured(all, level.grid, 1, SweepWithParents<false>{level, levels.level[l + 1]});
      if (l > 0) each_coloured(all, level.grid, 0, Sweep{level});
    }
    // If one block processed all levels, the last sweep is repeated without a change.
    return last_sweep(all, levels.level[0]);
  }
  template <class All>
  static SIMPLEXSEG_HD Totals last_sweep(const All& all, const LevelPointers& top) {
    if constexpr (All::kByRows) {
      return all.totals_of_rows(top.grid, [&](int j, int k) {
        each_coloured_of_row(top.grid, j, k, 0, Sweep{top});
        const int row = (k * top.grid.size[1] + j) * top.grid.size[0];
        return All::totals_of_range(row, row + top.grid.size[0], CorrectionOfCell{top.residual, top.correction});
      });
    } else {
      return all.totals(pair_count(top.grid), LastSweepOfPair{top});
    }
  }
};

}  // namespace simplexseg
