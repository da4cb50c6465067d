// SPDX-License-Identifier: Apache-2.0
// Kernels of the solver of the random walker (walker.h): a multigrid cycle in four passes per level. The first half of
// a red-black sweep from zero gives r / d, so the second colour computes that from r, the residual of the first colour
// is the flow from the second one, and only the next sweep of the second colour needs the coarse correction of the
// first.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "field/parallel/executor.h"
#include "field/walker_kernels.h"

namespace simplexseg {

inline constexpr int kMaxLevels = 12;
inline constexpr int kCoarsestSweeps = 3;  ///< before and after the middle sweep; more save no iteration

struct LevelPointers {
  LevelView edges;
  BoxGrid grid;
  int shift[3];  ///< 1 along an axis along which the next level has half the cells, else 0
  float *mass, *diagonal, *correction, *residual;

  SIMPLEXSEG_HD int count() const { return grid.count(); }
  /// Sum of weight times value(u) over the six neighbours u. Beyond the box, where weights are 0, value(u) of any
  /// cell within one plane of v is evaluated.
  template <class Value>
  SIMPLEXSEG_HD float flow(int v, const Value& value) const {
    const int row = edges.row, plane = edges.plane;
    return edges.wx[v] * value(v + 1) + edges.wx[v - 1] * value(v - 1) + edges.wy[v] * value(v + row) +
           edges.wy[v - row] * value(v - row) + edges.wz[v] * value(v + plane) + edges.wz[v - plane] * value(v - plane);
  }
};

struct StartOfSolution {
  StartResidual residual;
  HeldIntoMass mass;
  const float* field;
  float* inner;
  SIMPLEXSEG_HD void operator()(int v) const {
    residual(v);
    mass(v);
    inner[v] = field[v];
  }
};

struct CutAllHeldEdges {
  const std::uint8_t* held;
  float* weight[3];
  int stride[3];
  SIMPLEXSEG_HD void operator()(int v) const {
    for (int a = 0; a < 3; ++a) CutHeldEdges{held, weight[a], stride[a]}(v);
  }
};

struct AllConductances {
  Conductance along[3];
  float* weight[3];
  BoxGrid grid;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    weight[0][at.v] = at.i + 1 < grid.size[0] ? along[0](at.v) : 0.0f;
    weight[1][at.v] = at.j + 1 < grid.size[1] ? along[1](at.v) : 0.0f;
    weight[2][at.v] = at.k + 1 < grid.size[2] ? along[2](at.v) : 0.0f;
  }
};

/// Sums over the cells of a coarse cell.
struct Coarsen {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(int to) const {
    const CellAt at = cell_at(coarse.grid, to);
    const int first[3]{at.i << fine.shift[0], at.j << fine.shift[1], at.k << fine.shift[2]};
    int last[3];
    for (int a = 0; a < 3; ++a) last[a] = smaller(first[a] + (1 << fine.shift[a]), fine.grid.size[a]) - 1;
    float mass = 0, wx = 0, wy = 0, wz = 0;
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) {
          const int v = (z * fine.grid.size[1] + y) * fine.grid.size[0] + x;
          mass += fine.mass[v];
          if (x == last[0]) wx += fine.edges.wx[v];
          if (y == last[1]) wy += fine.edges.wy[v];
          if (z == last[2]) wz += fine.edges.wz[v];
        }
    coarse.mass[to] = mass;
    const_cast<float*>(coarse.edges.wx)[to] = wx;
    const_cast<float*>(coarse.edges.wy)[to] = wy;
    const_cast<float*>(coarse.edges.wz)[to] = wz;
  }
};

/// Both colours from zero; writes the second.
struct FirstSweep {
  LevelPointers level;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const float *const r = level.residual, *const inverse = level.diagonal;
    const float flow = level.flow(at.v, [=](int u) { return r[u] * inverse[u]; });
    level.correction[at.v] = (r[at.v] + flow) * inverse[at.v];
  }
};

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
          sum += fine.flow((k * grid.size[1] + j) * grid.size[0] + i, [=](int u) { return z[u]; });
      }
    coarse.residual[at.v] = sum;
  }
  /// The same for a row of the coarse level, on the CPU.
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
          for (int half = 0; half < count; ++half) out[half] += level.flow(z, first + 2 * half);
        } else {
          for (int half = 0; half < count; ++half) out[2 * half + odd] += level.flow(z, first + 2 * half);
        }
      }
  }
};

template <class Team>
SIMPLEXSEG_HD void restrict_residual(const Team& team, const RestrictResidual& kernel) {
  if constexpr (Team::kByRows)
    team.each_row(kernel.coarse.grid, [&](int j, int k) { kernel.row(j, k); });
  else
    each_cell(team, kernel.coarse.grid, kernel);
}

/// The second colour, the coarse correction being added to the first. `kHalved`: whether the next level has half the
/// cells along i.
template <bool kHalved>
struct SweepWithParents {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const float *const r = fine.residual, *const inverse = fine.diagonal, *const parents = coarse.correction;
    const LevelView& edges = fine.edges;
    const int row = edges.row, plane = edges.plane, v = at.v;
    // Neighbours beyond the box, whose weights are 0, are replaced by the cell itself.
    const int below = at.j > 0, above = at.j + 1 < fine.grid.size[1], under = at.k > 0,
              over = at.k + 1 < fine.grid.size[2];
    // Parents of the cell and of its neighbours along i, linear in at.half.
    const int own = kHalved ? at.half : at.i, left = kHalved ? at.half + ((at.odd - at.left) >> 1) : at.i - at.left,
              right = kHalved ? at.half + ((at.odd + at.right) >> 1) : at.i + at.right;
    const auto line = [&](int j, int k) {
      return ((k >> fine.shift[2]) * coarse.grid.size[1] + (j >> fine.shift[1])) * coarse.grid.size[0];
    };
    const auto value = [=](int u, int parent) { return r[u] * inverse[u] + parents[parent]; };
    const int here = line(at.j, at.k);
    const float flow = edges.wx[v] * value(v + at.right, here + right) +
                       edges.wx[v - 1] * value(v - at.left, here + left) +
                       edges.wy[v] * value(v + above * row, line(at.j + above, at.k) + own) +
                       edges.wy[v - row] * value(v - below * row, line(at.j - below, at.k) + own) +
                       edges.wz[v] * value(v + over * plane, line(at.j, at.k + over) + own) +
                       edges.wz[v - plane] * value(v - under * plane, line(at.j, at.k - under) + own);
    fine.correction[v] = (r[v] + flow) * inverse[v];
  }
};

/// A sweep of one colour from the values of the other.
struct Sweep {
  LevelPointers level;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    // Where there is no neighbour, and the weight is 0, a cell reads itself: beyond the end of a row there is a cell
    // of the same colour, which another thread may be writing.
    const int below = at.j > 0 ? level.edges.row : 0, above = at.j + 1 < level.grid.size[1] ? level.edges.row : 0;
    const float flow = level.edges.flow(level.correction, at.v, at.left, at.right, below, above);
    level.correction[at.v] = (level.residual[at.v] + flow) * level.diagonal[at.v];
  }
};

/// Residual times correction, and the size of the correction, of a cell.
struct CorrectionOfCell {
  const float *residual, *correction;
  SIMPLEXSEG_HD OfTotals operator()(int v) const { return {residual[v] * correction[v], std::fabs(correction[v])}; }
};
/// The same of pair t of half_count(), two cells along i, the first colour of which is swept first.
struct LastSweepOfPair {
  LevelPointers level;
  SIMPLEXSEG_HD OfTotals operator()(int t) const {
    const BoxGrid& grid = level.grid;
    const int half = (grid.size[0] + 1) / 2, row = t / half, j = row % grid.size[1], k = row / grid.size[1];
    const int i = 2 * (t % half), first = i + ((j + k) & 1), second = i + 1 - ((j + k) & 1);
    const CorrectionOfCell of{level.residual, level.correction};
    OfTotals all{0, 0};
    if (first < grid.size[0]) {
      const CellAt at = cell_at(grid, first, j, k);
      Sweep{level}(at);
      all = of(at.v);
    }
    if (second < grid.size[0]) {
      const OfTotals other = of(cell_at(grid, second, j, k).v);
      all = {all.value + other.value, larger(other.size, all.size)};
    }
    return all;
  }
};

struct WalkerLevels {
  int count;
  int first_of_some;  ///< finest level that is processed by a part of the threads, where waiting for all costs more
  LevelPointers level[kMaxLevels];
};

/// kernel(v) for all 0 <= v < n by the threads of a block, which then wait for each other.
template <class Team, class Kernel>
SIMPLEXSEG_HD void each_of_block(const Team& team, int n, const Kernel& kernel) {
  for (int v = team.thread; v < n; v += Team::threads) kernel(v);
  team.sync();
}
template <class Team, class Kernel>
SIMPLEXSEG_HD void each_coloured_of_block(const Team& team, const BoxGrid& grid, int colour, const Kernel& kernel) {
  if constexpr (Team::kByRows)
    each_coloured(team, grid, colour, kernel);
  else
    each_of_block(team, half_count(grid), KernelOfColour<Kernel>{grid, colour, kernel});
}

struct BuildCoarse {
  const WalkerLevels& levels;
  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team) const {
    for (int l = levels.first_of_some + 1; l < levels.count; ++l) {
      const LevelPointers& level = levels.level[l];
      each_of_block(team, level.count(), Coarsen{levels.level[l - 1], level});
      each_of_block(team, level.count(), InverseDiagonal{level.edges, level.mass, level.diagonal});
    }
  }
};

struct SweepsOfCoarsest {
  const LevelPointers& level;
  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team) const {
    const auto sweep = [&](int colour) { each_coloured_of_block(team, level.grid, colour, Sweep{level}); };
    each_coloured_of_block(team, level.grid, 1, FirstSweep{level});
    for (int s = 0; s < kCoarsestSweeps; ++s) {
      sweep(0);
      sweep(1);
    }
    sweep(0);
    for (int s = 0; s < kCoarsestSweeps; ++s) {  // the same in reverse order: the cycle is symmetric
      sweep(1);
      sweep(0);
    }
  }
};

struct CycleOfCoarse {
  const WalkerLevels& levels;
  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team) const {
    const int first = levels.first_of_some, last = levels.count - 1;
    for (int l = first; l < last; ++l) {
      const LevelPointers &level = levels.level[l], &coarse = levels.level[l + 1];
      each_coloured_of_block(team, level.grid, 1, FirstSweep{level});
      const RestrictResidual kernel{level, coarse};
      if constexpr (Team::kByRows)
        restrict_residual(team, kernel);
      else
        each_of_block(team, coarse.count(), KernelOfCells<RestrictResidual>{coarse.grid, kernel});
    }
    team.warp(SweepsOfCoarsest{levels.level[last]});
    for (int l = last - 1; l >= first; --l) {
      const LevelPointers& level = levels.level[l];
      if (level.shift[0] != 0)
        each_coloured_of_block(team, level.grid, 1, SweepWithParents<true>{level, levels.level[l + 1]});
      else
        each_coloured_of_block(team, level.grid, 1, SweepWithParents<false>{level, levels.level[l + 1]});
      each_coloured_of_block(team, level.grid, 0, Sweep{level});
    }
  }
};

/// Adds the last correction, which has the size of the remaining error.
struct LastCorrection {
  const float *x, *z;
  const std::uint8_t* held;
  float* to;
  SIMPLEXSEG_HD void operator()(int v) const { to[v] = held[v] ? x[v] : smaller(larger(x[v] + z[v], 0.0f), 1.0f); }
};

struct ApplyForTotals {
  Apply apply;
  SIMPLEXSEG_HD OfTotals operator()(int v) const { return {apply(v), 0}; }
};

/// State of a solution between two calls. The correction of its residual is known.
struct WalkerState {
  double product, product_before;  ///< of residual and correction, now and a step before
  float error;                     ///< largest correction
  int taken;                       ///< steps of the conjugate gradients
  int iterations;                  ///< of the last call
};

/// Conjugate gradients with a multigrid cycle as the preconditioner, by a team of all threads. Pointers are to a value
/// for each cell of the finest level.
struct SolveWalker {
  WalkerLevels levels;
  const std::uint8_t* target;
  std::uint8_t* held;  ///< padded
  float *field, *inner, *direction;
  double tolerance;
  int most_iterations;
  bool resumes;
  WalkerState* state;

  template <class All>
  SIMPLEXSEG_KERNEL void operator()(const All& all) const {
    const LevelPointers& top = levels.level[0];
    const int n = top.count();
    float *const r = top.residual, *const z = top.correction, *const p = direction;
    WalkerState now{};
    float first_error = 0;
    if (resumes)
      now = *state;
    else
      begin(all);
    for (now.iterations = 0;; ++now.iterations) {
      if (!resumes || now.iterations > 0) {
        const Totals totals = cycle(all);
        now.product_before = now.product;
        now.product = totals.sum, now.error = totals.largest;
      }
      if (now.iterations == 0) first_error = now.error;
      if (!(now.error > tolerance) || now.iterations == most_iterations || !(now.product > 0)) break;
      all.report(first_error, now.error, tolerance);
      all.each(n, NewDirection{now.taken == 0 ? 0.0f : static_cast<float>(now.product / now.product_before), z, p});
      const double curvature = all.totals(n, ApplyForTotals{{top.edges, p, z}}).sum;
      all.each(n, Advance{curvature > 0 ? static_cast<float>(now.product / curvature) : 0.0f, p, z, inner, r});
      ++now.taken;
    }
    all.each(n, LastCorrection{inner, z, held, field});
    if (all.is_first()) *state = now;
  }

 private:
  template <class All>
  SIMPLEXSEG_HD void begin(const All& all) const {
    const LevelPointers& top = levels.level[0];
    const LevelView& v = top.edges;
    all.each(top.count(),
             StartOfSolution{{v, field, top.mass, target, held, top.residual}, {v, held, top.mass}, field, inner});
    float* const weight[3]{const_cast<float*>(v.wx), const_cast<float*>(v.wy), const_cast<float*>(v.wz)};
    all.each(top.count(), CutAllHeldEdges{held, {weight[0], weight[1], weight[2]}, {1, v.row, v.plane}});
    const int last = smaller(levels.first_of_some, levels.count - 1);
    for (int l = 0; l <= last; ++l) {
      const LevelPointers& level = levels.level[l];
      if (l > 0) all.each(level.count(), Coarsen{levels.level[l - 1], level});
      all.each(level.count(), InverseDiagonal{level.edges, level.mass, level.diagonal});
    }
    all.some(BuildCoarse{levels});
  }
  /// Returns the totals of the corrections.
  template <class All>
  SIMPLEXSEG_HD Totals cycle(const All& all) const {
    const int some = levels.first_of_some;
    for (int l = 0; l < some; ++l) {
      const LevelPointers &level = levels.level[l], &coarse = levels.level[l + 1];
      each_coloured(all, level.grid, 1, FirstSweep{level});
      restrict_residual(all, RestrictResidual{level, coarse});
    }
    all.some(CycleOfCoarse{levels});
    for (int l = some - 1; l >= 0; --l) {
      const LevelPointers& level = levels.level[l];
      if (level.shift[0] != 0)
        each_coloured(all, level.grid, 1, SweepWithParents<true>{level, levels.level[l + 1]});
      else
        each_coloured(all, level.grid, 1, SweepWithParents<false>{level, levels.level[l + 1]});
      if (l > 0) each_coloured(all, level.grid, 0, Sweep{level});
    }
    // If a part of the threads processed all levels, the last sweep is a repetition that changes nothing.
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
      return all.totals(half_count(top.grid), LastSweepOfPair{top});
    }
  }
};

}  // namespace simplexseg
