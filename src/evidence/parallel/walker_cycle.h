// SPDX-License-Identifier: Apache-2.0
// Kernels of ParallelWalker: a multigrid cycle in four passes a level. What a red-black sweep from zero writes is r /
// d, so the second colour takes that from r itself, what is left of the first colour's residual is the flow from the
// second, and what a coarser level adds to the first colour is needed by the second one's next sweep alone.
#pragma once
#include <cmath>
#include <cstdint>

#include "evidence/parallel/executor.h"
#include "evidence/walker_kernels.h"

namespace simplexseg {

inline constexpr int kMostLevels = 12;
inline constexpr int kTeamSweeps = 3;  ///< of the coarsest level before and after; more save no iteration

struct LevelPointers {
  LevelView edges;
  int size[3];
  int step[3];  ///< 2 along an axis along which the next level has half the voxels, else 1
  float *mass, *diagonal, *correction, *residual;

  SIMPLEXSEG_HD int count() const { return size[0] * size[1] * size[2]; }
  SIMPLEXSEG_HD int row_half() const { return (size[0] + 1) / 2; }
  SIMPLEXSEG_HD int half_count() const { return row_half() * size[1] * size[2]; }
  struct At {
    int i, j, k, v;
  };
  SIMPLEXSEG_HD At at(int v) const { return {v % size[0], v / size[0] % size[1], v / (size[0] * size[1]), v}; }
  /// The t-th voxel of a colour, i + j + k even or odd; i may lie behind the row's end.
  SIMPLEXSEG_HD At coloured(int t, int colour) const {
    const int half = row_half(), row = t / half, j = row % size[1], k = row / size[1];
    const int i = 2 * (t % half) + ((j + k + colour) & 1);
    return {i, j, k, row * size[0] + i};
  }
  /// The sum of weight times value(u) over the six neighbours u; value is asked beyond the box, too, where weights are
  /// 0.
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
  int size[3];
  SIMPLEXSEG_HD void operator()(int v) const {
    const int at[3]{v % size[0], v / size[0] % size[1], v / (size[0] * size[1])};
    for (int a = 0; a < 3; ++a) weight[a][v] = at[a] + 1 < size[a] ? along[a](v) : 0.0f;
  }
};

/// The sums over the voxels of a coarser level's voxel.
struct Coarsen {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(int to) const {
    const LevelPointers::At at = coarse.at(to);
    const int first[3]{at.i * fine.step[0], at.j * fine.step[1], at.k * fine.step[2]};
    int last[3];
    for (int a = 0; a < 3; ++a) last[a] = smaller(first[a] + fine.step[a], fine.size[a]) - 1;
    float mass = 0, wx = 0, wy = 0, wz = 0;
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) {
          const int v = (z * fine.size[1] + y) * fine.size[0] + x;
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
  SIMPLEXSEG_HD void operator()(int t) const {
    const LevelPointers::At at = level.coloured(t, 1);
    if (at.i >= level.size[0]) return;
    const float *const r = level.residual, *const inverse = level.diagonal;
    const float flow = level.flow(at.v, [=](int u) { return r[u] * inverse[u]; });
    level.correction[at.v] = (r[at.v] + flow) * inverse[at.v];
  }
};

struct RestrictResidual {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(int to) const {
    const LevelPointers::At at = coarse.at(to);
    const float* const z = fine.correction;
    float sum = 0;
    for (int k = at.k * fine.step[2]; k < smaller((at.k + 1) * fine.step[2], fine.size[2]); ++k)
      for (int j = at.j * fine.step[1]; j < smaller((at.j + 1) * fine.step[1], fine.size[1]); ++j)
        for (int i = at.i * fine.step[0]; i < smaller((at.i + 1) * fine.step[0], fine.size[0]); ++i)
          if (((i + j + k) & 1) == 0)
            sum += fine.flow((k * fine.size[1] + j) * fine.size[0] + i, [=](int u) { return z[u]; });
    coarse.residual[to] = sum;
  }
};

/// The second colour, what the coarser level says added to the first.
struct SweepWithParents {
  LevelPointers fine, coarse;
  SIMPLEXSEG_HD void operator()(int t) const {
    const LevelPointers::At at = fine.coloured(t, 1);
    if (at.i >= fine.size[0]) return;
    const float *const r = fine.residual, *const inverse = fine.diagonal, *const parents = coarse.correction;
    const int di = fine.step[0], dj = fine.step[1], dk = fine.step[2];
    const int line = (at.k / dk * coarse.size[1] + at.j / dj) * coarse.size[0];
    const int row = fine.edges.row, plane = fine.edges.plane, v = at.v;
    const auto value = [=](int u, int parent) { return r[u] * inverse[u] + parents[parent]; };
    float flow = 0;
    // Beyond the box weights are 0, and so are the values around the arrays.
    if (at.i + 1 < fine.size[0]) flow += fine.edges.wx[v] * value(v + 1, line + (at.i + 1) / di);
    if (at.i > 0) flow += fine.edges.wx[v - 1] * value(v - 1, line + (at.i - 1) / di);
    const int own = at.i / di;
    if (at.j + 1 < fine.size[1])
      flow += fine.edges.wy[v] * value(v + row, (at.k / dk * coarse.size[1] + (at.j + 1) / dj) * coarse.size[0] + own);
    if (at.j > 0)
      flow += fine.edges.wy[v - row] *
              value(v - row, (at.k / dk * coarse.size[1] + (at.j - 1) / dj) * coarse.size[0] + own);
    if (at.k + 1 < fine.size[2])
      flow +=
          fine.edges.wz[v] * value(v + plane, ((at.k + 1) / dk * coarse.size[1] + at.j / dj) * coarse.size[0] + own);
    if (at.k > 0)
      flow += fine.edges.wz[v - plane] *
              value(v - plane, ((at.k - 1) / dk * coarse.size[1] + at.j / dj) * coarse.size[0] + own);
    fine.correction[v] = (r[v] + flow) * inverse[v];
  }
};

/// A sweep of one colour from what the other has.
struct Sweep {
  LevelPointers level;
  int colour;
  SIMPLEXSEG_HD void operator()(int t) const {
    const LevelPointers::At at = level.coloured(t, colour);
    if (at.i >= level.size[0]) return;
    const float* const z = level.correction;
    const float flow = level.flow(at.v, [=](int u) { return z[u]; });
    level.correction[at.v] = (level.residual[at.v] + flow) * level.diagonal[at.v];
  }
};
struct LastSweep {
  LevelPointers level;
  SIMPLEXSEG_HD void operator()(int t) const { Sweep{level, 0}(t); }
};

/// The last sweep of the top level, the first colour's, and what both colours' corrections say of the whole.
struct LastSweepAndTotals {
  LevelPointers level;
  SIMPLEXSEG_HD OfTotals operator()(int t) const {
    OfTotals all{0, 0};
    const LevelPointers::At second = level.coloured(t, 1);
    if (second.i < level.size[0]) add(second.v, level.correction[second.v], all);
    const LevelPointers::At first = level.coloured(t, 0);
    if (first.i >= level.size[0]) return all;
    Sweep{level, 0}(t);
    add(first.v, level.correction[first.v], all);
    return all;
  }

 private:
  SIMPLEXSEG_HD void add(int v, float correction, OfTotals& all) const {
    all.value += level.residual[v] * correction;
    all.size = larger(std::fabs(correction), all.size);
  }
};

struct WalkerLevels {
  int count;
  int first_of_some;  ///< the finest of those that a part of the threads goes through: where waiting for all costs more
  LevelPointers level[kMostLevels];
};

/// kernel(v) for all 0 <= v < n by the threads of a team, which then wait for each other.
template <class Team, class Kernel>
SIMPLEXSEG_HD void each_of_team(const Team& team, int n, const Kernel& kernel) {
  for (int v = team.thread; v < n; v += Team::threads) kernel(v);
  team.sync();
}

struct BuildCoarse {
  const WalkerLevels& levels;
  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team) const {
    for (int l = levels.first_of_some + 1; l < levels.count; ++l) {
      const LevelPointers& level = levels.level[l];
      each_of_team(team, level.count(), Coarsen{levels.level[l - 1], level});
      each_of_team(team, level.count(), InverseDiagonal{level.edges, level.mass, level.diagonal});
    }
  }
};

struct SweepsOfCoarsest {
  const LevelPointers& level;
  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team) const {
    const int half = level.half_count();
    each_of_team(team, half, FirstSweep{level});
    for (int s = 0; s < kTeamSweeps; ++s) {
      each_of_team(team, half, Sweep{level, 0});
      each_of_team(team, half, Sweep{level, 1});
    }
    each_of_team(team, half, Sweep{level, 0});
    for (int s = 0; s < kTeamSweeps; ++s) {  // the same backwards: the cycle is symmetric
      each_of_team(team, half, Sweep{level, 1});
      each_of_team(team, half, Sweep{level, 0});
    }
  }
};

struct CycleOfCoarse {
  const WalkerLevels& levels;
  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team) const {
    const int first = levels.first_of_some, last = levels.count - 1;
    for (int l = first; l < last; ++l) {
      each_of_team(team, levels.level[l].half_count(), FirstSweep{levels.level[l]});
      each_of_team(team, levels.level[l + 1].count(), RestrictResidual{levels.level[l], levels.level[l + 1]});
    }
    team.warp(SweepsOfCoarsest{levels.level[last]});
    for (int l = last - 1; l >= first; --l) {
      each_of_team(team, levels.level[l].half_count(), SweepWithParents{levels.level[l], levels.level[l + 1]});
      each_of_team(team, levels.level[l].half_count(), LastSweep{levels.level[l]});
    }
  }
};

/// The last correction is known, and of the size of the error that is left.
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

/// Where a solution stands, from one call to the next. The correction of its residual is known.
struct WalkerState {
  double product, product_before;  ///< of residual and correction, now and a step before
  float error;                     ///< largest correction
  int taken;                       ///< steps of the conjugate gradients
  int iterations;                  ///< of the last call
};

/// RandomWalker::solve(), or with `carries_on` more of what was begun, by a team of all threads. Pointers are to values
/// for each voxel of the top level.
struct SolveWalker {
  WalkerLevels levels;
  const std::uint8_t* target;
  std::uint8_t* held;  ///< padded
  float *field, *inner, *direction;
  double tolerance;
  int most_iterations;
  bool carries_on;
  WalkerState* state;

  template <class All>
  SIMPLEXSEG_KERNEL void operator()(const All& all) const {
    const LevelPointers& top = levels.level[0];
    const int n = top.count();
    float *const r = top.residual, *const z = top.correction, *const p = direction;
    WalkerState now{};
    if (carries_on)
      now = *state;
    else
      begin(all);
    for (now.iterations = 0;; ++now.iterations) {
      if (!carries_on || now.iterations > 0) {
        const Totals totals = cycle(all);
        now.product_before = now.product;
        now.product = totals.sum, now.error = totals.largest;
      }
      if (!(now.error > tolerance) || now.iterations == most_iterations || !(now.product > 0)) break;
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
  /// Returns what the corrections are.
  template <class All>
  SIMPLEXSEG_HD Totals cycle(const All& all) const {
    const int some = levels.first_of_some;
    for (int l = 0; l < some; ++l) {
      all.each(levels.level[l].half_count(), FirstSweep{levels.level[l]});
      all.each(levels.level[l + 1].count(), RestrictResidual{levels.level[l], levels.level[l + 1]});
    }
    all.some(CycleOfCoarse{levels});
    for (int l = some - 1; l >= 0; --l) {
      all.each(levels.level[l].half_count(), SweepWithParents{levels.level[l], levels.level[l + 1]});
      if (l > 0) all.each(levels.level[l].half_count(), LastSweep{levels.level[l]});
    }
    // Where a part of the threads did all of it the last sweep changes nothing: it is repeated.
    return all.totals(levels.level[0].half_count(), LastSweepAndTotals{levels.level[0]});
  }
};

}  // namespace simplexseg
