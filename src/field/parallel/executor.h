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

/// Position of a cell in a grid.
struct CellAt {
  int i, j, k;
  int v;            ///< index in an array of all cells
  int left, right;  ///< distance in the array to the neighbours along i; 0 without a neighbour
  int half, odd;    ///< i = 2 half + odd
};
SIMPLEXSEG_HD CellAt cell_at(const BoxGrid& grid, int i, int j, int k) {
  return {i,     j,    k, (k * grid.size[1] + j) * grid.size[0] + i, i > 0 ? 1 : 0, i + 1 < grid.size[0] ? 1 : 0,
          i / 2, i % 2};
}
SIMPLEXSEG_HD CellAt cell_at(const BoxGrid& grid, int v) {
  return cell_at(grid, v % grid.size[0], v / grid.size[0] % grid.size[1], v / grid.plane());
}

/// Kernel over indices v that calls kernel(CellAt).
template <class Kernel>
struct KernelOfCells {
  BoxGrid grid;
  Kernel kernel;
  SIMPLEXSEG_HD void operator()(int v) const { kernel(cell_at(grid, v)); }
};

/// Kernel over indices t that calls kernel(CellAt) for the t-th cell of a colour: i + j + k even (0) or odd (1).
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
/// Number of pairs of cells along i; each has at most one cell of a colour.
SIMPLEXSEG_HD int pair_count(const BoxGrid& grid) { return (grid.size[0] + 1) / 2 * grid.size[1] * grid.size[2]; }

/// Block of one CPU thread. A kernel for a block distributes its loops (v = block.thread; v < n; v += block.threads)
/// and synchronises the threads by block.sync(), or by block.any(x), which returns whether x is true for any of them. A
/// kernel for several blocks declares kScratch, the number of floats of memory of each block.
struct SerialBlock {
  static constexpr bool kByRows = true;  ///< cells are visited row by row, in ascending order
  static constexpr int thread = 0, threads = 1;
  float* scratch = nullptr;
  void sync() const {}
  bool any(bool x) const { return x; }
  /// Runs kernel(warp) by one warp of the block, for small loops; the other threads wait.
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

/// Sum of the values of all elements, in double and in a fixed order, and the largest magnitude.
struct Totals {
  double sum = 0;
  float largest = 0;
};
/// Contribution of an element to Totals; `magnitude` >= 0.
struct Contribution {
  float value, magnitude;
};

/// Largest number of sums of a pass.
inline constexpr int kMostSums = 4;
/// Values of an element that are summed separately, and their sums.
template <int kNumbers>
struct Summands {
  static constexpr int kCount = kNumbers;
  float values[kCount];
};
template <int kCount>
struct SumsOf {
  double values[kCount];
};
template <int kCount>
SIMPLEXSEG_HD void add(const Summands<kCount>& x, SumsOf<kCount>& sums) {
  for (int s = 0; s < kCount; ++s) sums.values[s] += x.values[s];
}

/// Calls kernel(CellAt) for the cells of a colour in a row (KernelOfColour).
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
/// Calls kernel(CellAt) for all cells of a colour, by all threads of a group (a block or all threads).
template <class Group, class Kernel>
SIMPLEXSEG_HD void each_coloured(const Group& group, const BoxGrid& grid, int colour, const Kernel& kernel) {
  if constexpr (Group::kByRows) {
    group.each_row(grid, [&](int j, int k) { each_coloured_of_row(grid, j, k, colour, kernel); });
  } else {
    group.each(pair_count(grid), KernelOfColour<Kernel>{grid, colour, kernel});
  }
}

/// Calls kernel(CellAt) for all cells of a grid, by all threads of a group.
template <class Group, class Kernel>
SIMPLEXSEG_HD void each_cell(const Group& group, const BoxGrid& grid, const Kernel& kernel) {
  if constexpr (Group::kByRows) {
    group.each_row(grid, [&](int j, int k) {
      const Kernel own = kernel;
      const int n = grid.size[0], row = (k * grid.size[1] + j) * n;
      own(cell_at(grid, 0, j, k));
      for (int i = 1; i + 1 < n; ++i) own(CellAt{i, j, k, row + i, 1, 1, i / 2, i % 2});
      if (n > 1) own(cell_at(grid, n - 1, j, k));
    });
  } else {
    group.each(grid.count(), KernelOfCells<Kernel>{grid, kernel});
  }
}

/// List in the memory of an executor whose values are replaced; memory is allocated when it must grow.
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

/// Waits for a download of one value and returns it.
template <class T, class Executor>
T received(const Executor& executor, const typename Executor::template Fetched<T>& fetched) {
  T value{};
  executor.receive(fetched, std::span<T>(&value, 1));
  return value;
}

}  // namespace simplexseg
