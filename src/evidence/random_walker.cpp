// SPDX-License-Identifier: Apache-2.0
#include "evidence/random_walker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/vec3.h"
#include "evidence/walker_kernels.h"

namespace simplexseg {
namespace {

LevelView view(const BoxGrid& grid, const std::array<PaddedArray<float>, 3>& weight,
               const PaddedArray<float>& diagonal) {
  return {grid.row(), grid.plane(), weight[0].data(), weight[1].data(), weight[2].data(), diagonal.data()};
}

/// Calls kernel(j, k) for all rows of a grid, some rows together as one job.
template <class Kernel>
void for_each_row(const RunJobs& run, const BoxGrid& grid, const Kernel& kernel) {
  const int rows = grid.size[1] * grid.size[2];
  const int rows_a_job = std::max(1, indices_a_block / std::max(1, grid.size[0]));
  run((rows + rows_a_job - 1) / rows_a_job, [&](int job) {
    const int last = std::min(rows, (job + 1) * rows_a_job);
    for (int r = job * rows_a_job; r < last; ++r) kernel(r % grid.size[1], r / grid.size[1]);
  });
}

}  // namespace

std::vector<WalkerLevelShape> walker_levels(const BoxGrid& grid, const std::array<double, 3>& spacing_mm) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  std::array<double, 3> strength;
  for (int a = 0; a < 3; ++a) strength[a] = (least / spacing_mm[a]) * (least / spacing_mm[a]);
  std::vector<WalkerLevelShape> levels;
  BoxGrid at = grid;
  while (true) {
    WalkerLevelShape& level = levels.emplace_back();
    level.grid = at;
    if (at.count() <= kCoarsestVoxels) return levels;
    double strongest = 0;
    for (int a = 0; a < 3; ++a)
      if (at.size[a] > 1) strongest = std::max(strongest, strength[a]);
    for (int a = 0; a < 3; ++a) {
      if (at.size[a] == 1 || strength[a] < 0.25 * strongest) continue;
      level.halved[a] = true;
      at.size[a] = (at.size[a] + 1) / 2;
      strength[a] /= 4;
    }
  }
}

RandomWalker::RandomWalker(const BoxGrid& grid, const std::array<double, 3>& spacing_mm, RunJobs run)
    : run_(std::move(run)), field_(grid), inner_(grid), direction_(grid) {
  for (const WalkerLevelShape& shape : walker_levels(grid, spacing_mm)) {
    Level& level = levels_.emplace_back();
    level.grid = shape.grid, level.halved = shape.halved;
    for (PaddedArray<float>& weight : level.weight) weight = PaddedArray<float>(shape.grid);
    for (PaddedArray<float>* array : {&level.mass, &level.diagonal, &level.correction, &level.residual})
      *array = PaddedArray<float>(shape.grid);
    // A sweep may read one that no sweep has written yet, by a weight of 0: where a row ends and the next begins.
    std::fill_n(level.correction.data(), shape.grid.count(), 0.0f);
  }
  std::ranges::fill(field(), 0.0f);
}

void RandomWalker::set_diagonal(Level& level) const {
  for_each_index(
      run_, level.grid.count(),
      InverseDiagonal{view(level.grid, level.weight, level.diagonal), level.mass.data(), level.diagonal.data()});
}

void RandomWalker::eliminate_held(std::span<const std::uint8_t> target, std::span<const std::uint8_t> held) {
  Level& level = levels_.front();
  const BoxGrid& g = level.grid;
  for (int axis = 0; axis < 3; ++axis) {  // no edge leads out of the box
    float* const w = level.weight[axis].data();
    for_each_row(run_, g, [&](int j, int k) {
      float* const row = w + (std::size_t(k) * g.size[1] + j) * g.size[0];
      if (axis == 0) row[g.size[0] - 1] = 0;
      if ((axis == 1 && j == g.size[1] - 1) || (axis == 2 && k == g.size[2] - 1)) std::fill_n(row, g.size[0], 0.0f);
    });
  }
  PaddedArray<std::uint8_t> padded(g);
  std::copy(held.begin(), held.end(), padded.data());
  const LevelView v = view(g, level.weight, level.diagonal);
  for_each_index(
      run_, g.count(),
      StartResidual{v, field_.data(), level.mass.data(), target.data(), padded.data(), level.residual.data()});
  for_each_index(run_, g.count(), HeldIntoMass{v, padded.data(), level.mass.data()});
  for (int axis = 0; axis < 3; ++axis)
    for_each_index(run_, g.count(), CutHeldEdges{padded.data(), level.weight[axis].data(), g.stride(axis)});
}

void RandomWalker::coarsen(const Level& fine, Level& coarse) const {
  const BoxGrid &f = fine.grid, &c = coarse.grid;
  const std::array<int, 3> step{fine.halved[0] ? 2 : 1, fine.halved[1] ? 2 : 1, fine.halved[2] ? 2 : 1};
  for_each_row(run_, c, [&](int j, int k) {
    for (int i = 0; i < c.size[0]; ++i) {
      const int first[3]{i * step[0], j * step[1], k * step[2]};
      int last[3];
      for (int a = 0; a < 3; ++a) last[a] = std::min(first[a] + step[a], f.size[a]) - 1;
      float mass = 0, sum[3]{};
      for (int z = first[2]; z <= last[2]; ++z) {
        for (int y = first[1]; y <= last[1]; ++y) {
          for (int x = first[0]; x <= last[0]; ++x) {
            const int v = (z * f.size[1] + y) * f.size[0] + x, at[3]{x, y, z};
            mass += fine.mass.data()[v];
            for (int a = 0; a < 3; ++a) {
              if (at[a] != last[a]) continue;
              const float* const w = fine.weight[a].data();
              sum[a] += w[v];
            }
          }
        }
      }
      const int to = (k * c.size[1] + j) * c.size[0] + i;
      coarse.mass.data()[to] = mass;
      for (int a = 0; a < 3; ++a) coarse.weight[a].data()[to] = sum[a];
    }
  });
}

void RandomWalker::build_levels() {
  set_diagonal(levels_.front());
  for (std::size_t l = 0; l + 1 < levels_.size(); ++l) {
    coarsen(levels_[l], levels_[l + 1]);
    set_diagonal(levels_[l + 1]);
  }
}

void RandomWalker::sweep(Level& level, int colour, bool from_zero) const {
  const LevelView v = view(level.grid, level.weight, level.diagonal);
  const float* const r = level.residual.data();
  float* const z = level.correction.data();
  const int n = level.grid.size[0];
  for_each_row(run_, level.grid, [=, &level](int j, int k) {
    const int row = (k * level.grid.size[1] + j) * n;
    // Where there is no neighbour in the grid, and the weight is 0, a voxel reads itself: what lies there in the array
    // is the end of another row, of this colour, which another thread may be writing.
    const int below = j == 0 ? 0 : v.row, above = j == level.grid.size[1] - 1 ? 0 : v.row;
    const auto solve = [=](int u, int left, int right) {
      z[u] = (r[u] + v.flow(z, u, left, right, below, above)) * v.inverse_diagonal[u];
    };
    if (from_zero) {  // the neighbours are taken as 0, and set to it
      for (int i = (j + k + colour) & 1; i < n; i += 2) z[row + i] = r[row + i] * v.inverse_diagonal[row + i];
    } else {
      int first = (j + k + colour) & 1, last = n;
      if (first == 0) {
        solve(row, 0, n > 1 ? 1 : 0);
        first = 2;
      }
      if (last - 1 >= first && ((last - 1 - first) & 1) == 0) {
        --last;
        solve(row + last, 1, 0);
      }
#pragma GCC ivdep
      for (int i = first; i < last; i += 2) solve(row + i, 1, 1);
    }
  });
}

void RandomWalker::restrict_residual(const Level& fine, Level& coarse) const {
  const LevelView v = view(fine.grid, fine.weight, fine.diagonal);
  const float *const r = fine.residual.data(), *const z = fine.correction.data();
  const BoxGrid &f = fine.grid, &c = coarse.grid;
  const int step[3]{fine.halved[0] ? 2 : 1, fine.halved[1] ? 2 : 1, fine.halved[2] ? 2 : 1};
  for_each_row(run_, c, [&](int j, int k) {
    float* const out = coarse.residual.data() + (std::size_t(k) * c.size[1] + j) * c.size[0];
    std::fill_n(out, c.size[0], 0.0f);
    for (int z_at = k * step[2]; z_at < std::min((k + 1) * step[2], f.size[2]); ++z_at) {
      for (int y = j * step[1]; y < std::min((j + 1) * step[1], f.size[1]); ++y) {
        const int row = (z_at * f.size[1] + y) * f.size[0];
        // Only the voxels swept first: the others were solved last, and have no residual.
        for (int i = (y + z_at) & 1; i < f.size[0]; i += 2) {
          const int u = row + i;
          out[step[0] == 2 ? i >> 1 : i] += r[u] + v.flow(z, u) - z[u] / v.inverse_diagonal[u];
        }
      }
    }
  });
}

void RandomWalker::cycle(std::size_t l) {
  Level& level = levels_[l];
  sweep(level, 0, true);
  sweep(level, 1, false);
  if (l + 1 == levels_.size()) {
    for (int s = 0; s < kCoarsestSweeps; ++s) {
      sweep(level, 0, false);
      sweep(level, 1, false);
    }
    for (int s = 0; s < kCoarsestSweeps; ++s) {  // the same backwards: the cycle is symmetric
      sweep(level, 1, false);
      sweep(level, 0, false);
    }
    sweep(level, 1, false);
    sweep(level, 0, false);
    return;
  }
  Level& coarse = levels_[l + 1];
  restrict_residual(level, coarse);
  cycle(l + 1);
  const BoxGrid &f = level.grid, &c = coarse.grid;
  const float* const from = coarse.correction.data();
  float* const z = level.correction.data();
  for_each_row(run_, f, [&](int j, int k) {
    const int row = (k * f.size[1] + j) * f.size[0];
    const int jc = level.halved[1] ? j >> 1 : j, kc = level.halved[2] ? k >> 1 : k;
    const float* const parent = from + (std::size_t(kc) * c.size[1] + jc) * c.size[0];
    for (int i = (j + k) & 1; i < f.size[0]; i += 2) z[row + i] += parent[level.halved[0] ? i >> 1 : i];
  });
  sweep(level, 1, false);
  sweep(level, 0, false);
}

RandomWalker::Report RandomWalker::solve(std::span<const std::uint8_t> target, std::span<const std::uint8_t> held,
                                         double tolerance, int most_iterations, const ReportProgress& progress) {
  eliminate_held(target, held);
  build_levels();
  std::ranges::copy(field(), inner_.data());
  std::fill_n(direction_.data(), grid().count(), 0.0f);
  cycled_ = false;
  product_ = 0;
  return resume(tolerance, most_iterations, progress);
}

RandomWalker::Report RandomWalker::resume(double tolerance, int most_iterations, const ReportProgress& progress) {
  Level& top = levels_.front();
  const int n = top.grid.count();
  const LevelView v = view(top.grid, top.weight, top.diagonal);
  float *const r = top.residual.data(), *const z = top.correction.data(), *const p = direction_.data();
  Report report;
  double first_error = 0;
  for (;; ++report.iterations) {
    if (!cycled_) cycle(0);
    cycled_ = true;
    report.error = largest_correction();
    if (report.iterations == 0) first_error = report.error;
    if (!(report.error > tolerance) || report.iterations == most_iterations) break;
    if (progress)
      progress(static_cast<float>(std::log(first_error / report.error) / std::log(first_error / tolerance)));
    const double next = sum_over_indices(run_, n, Product{r, z});
    if (!(next > 0)) break;
    for_each_index(run_, n, NewDirection{product_ > 0 ? static_cast<float>(next / product_) : 0.0f, z, p});
    product_ = next;
    // The product takes the correction's place, which a cycle sets anew.
    const double curvature = sum_over_indices(run_, n, Apply{v, p, z});
    cycled_ = false;
    if (!(curvature > 0)) {
      std::ranges::copy(std::span(inner_.data(), n), field_.data());
      return report;
    }
    for_each_index(run_, n, Advance{static_cast<float>(next / curvature), p, z, inner_.data(), r});
  }
  // The last correction is known, and of the size of the error that is left.
  for_each_index(
      run_, n, [x = inner_.data(), z, to = field_.data()](int u) { to[u] = smaller(larger(x[u] + z[u], 0.0f), 1.0f); });
  return report;
}

double RandomWalker::largest_correction() const {
  const int n = grid().count(), blocks = (n + indices_a_block - 1) / indices_a_block;
  std::vector<float> most(blocks);
  run_(blocks, [&, z = levels_.front().correction.data()](int b) {
    float m = 0;
    for (int u = b * indices_a_block; u < std::min(n, (b + 1) * indices_a_block); ++u) m = larger(std::fabs(z[u]), m);
    most[b] = m;
  });
  return *std::max_element(most.begin(), most.end());
}

std::size_t RandomWalker::bytes() const {
  std::size_t bytes = field_.bytes() + inner_.bytes() + direction_.bytes();
  for (const Level& level : levels_) {
    for (const PaddedArray<float>& weight : level.weight) bytes += weight.bytes();
    bytes += level.mass.bytes() + level.diagonal.bytes() + level.correction.bytes() + level.residual.bytes();
  }
  return bytes;
}

}  // namespace simplexseg
