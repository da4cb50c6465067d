// SPDX-License-Identifier: Apache-2.0
// Executors of the field solver (docs/adr/0041-one-field-solver.md). Its parts are templates over an executor, which
// owns arrays and runs kernels over their elements: functors, or lambdas that capture by value ([=] SIMPLEXSEG_KERNEL),
// which access arrays by pointers. Executors: CpuFieldExecutor (cpu_executor.h), which documents the interface, and
// CudaFieldExecutor (gpu/cuda_field_executor.h).
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "core/vec3.h"
#include "field/box_grid.h"

#ifdef __CUDACC__
#define SIMPLEXSEG_KERNEL __host__ __device__
#define SIMPLEXSEG_UNROLL_ALL _Pragma("unroll")  // so that arrays with these indices are registers
#define SIMPLEXSEG_UNROLL_LANES
#else
#define SIMPLEXSEG_KERNEL
#define SIMPLEXSEG_UNROLL_ALL
#define SIMPLEXSEG_UNROLL_LANES _Pragma("GCC unroll 32")  // after vectorisation, so that arrays are vector registers
#endif

namespace simplexseg {

/// A cell of a grid.
struct CellAt {
  int i, j, k;
  int v;            ///< index in an array of all cells
  int left, right;  ///< from v to the neighbours along i; 0 where there is none
  int half, odd;    ///< i = 2 half + odd
};
SIMPLEXSEG_HD CellAt cell_at(const BoxGrid& grid, int i, int j, int k) {
  return {i,     j,    k, (k * grid.size[1] + j) * grid.size[0] + i, i > 0 ? 1 : 0, i + 1 < grid.size[0] ? 1 : 0,
          i / 2, i % 2};
}
SIMPLEXSEG_HD CellAt cell_at(const BoxGrid& grid, int v) {
  return cell_at(grid, v % grid.size[0], v / grid.size[0] % grid.size[1], v / grid.plane());
}

/// kernel(v) as a kernel over CellAt.
template <class Kernel>
struct KernelOfCells {
  BoxGrid grid;
  Kernel kernel;
  SIMPLEXSEG_HD void operator()(int v) const { kernel(cell_at(grid, v)); }
};

/// kernel(t) for the t-th cell of a colour: i + j + k even (0) or odd (1).
template <class Kernel>
struct KernelOfColour {
  BoxGrid grid;
  int colour;
  const Kernel& kernel;
  SIMPLEXSEG_HD void operator()(int t) const {
    const int half = (grid.size[0] + 1) / 2, row = t / half, j = row % grid.size[1], k = row / grid.size[1];
    const int i = 2 * (t % half) + ((j + k + colour) & 1);
    if (i < grid.size[0]) kernel(cell_at(grid, i, j, k));
  }
};
SIMPLEXSEG_HD int half_count(const BoxGrid& grid) { return (grid.size[0] + 1) / 2 * grid.size[1] * grid.size[2]; }

/// Team of one CPU thread. A kernel for a team is run by a block of threads on a device: it distributes its loops
/// (v = team.thread; v < n; v += team.threads) and waits for the results of the other threads by team.sync(), or by
/// team.any(x), which returns whether x is true for any of them. A kernel of several teams that declares kScratch gets
/// that many floats of memory for each team.
struct SerialBlock {
  static constexpr bool kByRows = true;  ///< cells are visited row by row, in ascending order
  static constexpr int thread = 0, threads = 1;
  float* scratch = nullptr;
  void sync() const {}
  bool any(bool x) const { return x; }
  /// Runs kernel(team) by a part of the team, for small loops; the other threads wait.
  template <class Kernel>
  void warp(const Kernel& kernel) const {
    kernel(*this);
  }
  template <class Kernel>
  void each_row(const BoxGrid& grid, const Kernel& kernel) const {
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j) kernel(j, k);
  }
};

/// Number of bins of histogram().
inline constexpr int kBins = 2048;

/// Sum of the values of a pass, in double and in a fixed order, and the largest size.
struct Totals {
  double sum = 0;
  float largest = 0;
};
/// Contribution of one element; `size` >= 0.
struct OfTotals {
  float value, size;
};

/// Values that are summed one by one; at most kMostSums.
inline constexpr int kMostSums = 4;
template <int kNumbers>
struct Summands {
  static constexpr int kCount = kNumbers;
  float is[kCount];
};
template <int kCount>
struct SumsOf {
  double is[kCount];
};
template <int kCount>
SIMPLEXSEG_HD void add(const Summands<kCount>& x, SumsOf<kCount>& sums) {
  for (int s = 0; s < kCount; ++s) sums.is[s] += x.is[s];
}

/// Calls kernel(CellAt) for the cells of a row that have a colour (KernelOfColour).
template <class Kernel>
void each_coloured_of_row(const BoxGrid& grid, int j, int k, int colour, const Kernel& kernel) {
  const Kernel own = kernel;
  const int n = grid.size[0], row = (k * grid.size[1] + j) * n;
  const int odd = (j + k + colour) & 1;
  int first = odd, last = n;
  if (first == 0) {
    own(cell_at(grid, 0, j, k));
    first = 2;
  }
  if (last - 1 >= first && ((last - 1 - first) & 1) == 0) own(cell_at(grid, --last, j, k));
  const int begin = first / 2, end = (last - odd + 1) / 2;
#pragma GCC ivdep
  for (int half = begin; half < end; ++half) own(CellAt{2 * half + odd, j, k, row + 2 * half + odd, 1, 1, half, odd});
}
/// Calls kernel(CellAt) for all cells of a colour, by all threads of a team.
template <class Team, class Kernel>
SIMPLEXSEG_HD void each_coloured(const Team& team, const BoxGrid& grid, int colour, const Kernel& kernel) {
  if constexpr (Team::kByRows) {
    team.each_row(grid, [&](int j, int k) { each_coloured_of_row(grid, j, k, colour, kernel); });
  } else {
    team.each(half_count(grid), KernelOfColour<Kernel>{grid, colour, kernel});
  }
}

/// Calls kernel(CellAt) for all cells of a grid, by all threads of a team.
template <class Team, class Kernel>
SIMPLEXSEG_HD void each_cell(const Team& team, const BoxGrid& grid, const Kernel& kernel) {
  if constexpr (Team::kByRows) {
    team.each_row(grid, [&](int j, int k) {
      const Kernel own = kernel;
      const int n = grid.size[0], row = (k * grid.size[1] + j) * n;
      own(cell_at(grid, 0, j, k));
      for (int i = 1; i + 1 < n; ++i) own(CellAt{i, j, k, row + i, 1, 1, i / 2, i % 2});
      if (n > 1) own(cell_at(grid, n - 1, j, k));
    });
  } else {
    team.each(grid.count(), KernelOfCells<Kernel>{grid, kernel});
  }
}

/// A list in the executor's memory that is replaced now and then, and grows.
template <class Executor, class T>
class UploadedList {
 public:
  const T* set(const Executor& executor, std::span<const T> values) {
    if (values.size() > array_.size()) array_ = executor.template array<T>(2 * values.size());
    executor.upload(values, array_.data());
    return array_.data();
  }
  std::size_t bytes() const { return array_.bytes(); }

 private:
  typename Executor::template Array<T> array_;
};

/// Waits for a fetched value.
template <class T, class Executor>
T received(const Executor& executor, const typename Executor::template Fetched<T>& fetched) {
  T value{};
  executor.receive(fetched, std::span<T>(&value, 1));
  return value;
}

}  // namespace simplexseg
