// SPDX-License-Identifier: Apache-2.0
// Executor of the field solver on the CPU.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <mutex>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "field/parallel/executor.h"
#include "field/run_jobs.h"
#include "field/update_progress.h"

namespace simplexseg {

/// All threads of the CPU executor, for algorithms of several passes. A pass returns after all its calls.
class CpuGrid {
 public:
  static constexpr bool kByRows = true;

  /// `progress` may be empty.
  CpuGrid(const RunJobs& run, const ReportProgress& progress) : run_(run), progress_(progress) {}

  /// Calls kernel(v) for all 0 <= v < n.
  template <class Kernel>
  void each(int n, const Kernel& kernel) const {
    for_each_index(run_, n, kernel);
  }
  /// Calls kernel(j, k) for all rows of a grid.
  template <class Kernel>
  void each_row(const BoxGrid& grid, const Kernel& kernel) const {
    const int rows = grid.size[1] * grid.size[2], rows_per_job = rows_of_job(grid);
    run_jobs((rows + rows_per_job - 1) / rows_per_job, [&](int job) {
      for (int r = job * rows_per_job; r < std::min(rows, (job + 1) * rows_per_job); ++r)
        kernel(r % grid.size[1], r / grid.size[1]);
    });
  }
  /// Totals of kernel(v), Contribution, over all 0 <= v < n.
  template <class Kernel>
  Totals totals(int n, const Kernel& kernel) const {
    return totals_of_jobs((n + kIndicesPerJob - 1) / kIndicesPerJob, [&](int job) {
      return totals_of_range(job * kIndicesPerJob, std::min(n, (job + 1) * kIndicesPerJob), kernel);
    });
  }
  /// Sums of kernel(j, k), Totals, over all rows.
  template <class Kernel>
  Totals totals_of_rows(const BoxGrid& grid, const Kernel& kernel) const {
    const int rows = grid.size[1] * grid.size[2], rows_per_job = rows_of_job(grid);
    return totals_of_jobs((rows + rows_per_job - 1) / rows_per_job, [&](int job) {
      Totals all;
      for (int r = job * rows_per_job; r < std::min(rows, (job + 1) * rows_per_job); ++r)
        add(kernel(r % grid.size[1], r / grid.size[1]), all);
      return all;
    });
  }
  /// Totals of kernel(v), first <= v < last: short ranges are summed in float, in lanes that the compiler vectorises.
  template <class Kernel>
  static Totals totals_of_range(int first, int last, const Kernel& kernel) {
    constexpr int kLanes = 8, kShort = 512;
    const Kernel k = kernel;
    Totals all;
    for (int start = first; start < last; start += kShort) {
      const int stop = std::min(last, start + kShort);
      std::array<float, kLanes> sum{}, largest{};
      int v = start;
      for (; v + kLanes <= stop; v += kLanes) {
#pragma GCC ivdep
        for (int l = 0; l < kLanes; ++l) {
          const Contribution x = k(v + l);
          sum[l] += x.value;
          largest[l] = larger(x.magnitude, largest[l]);
        }
      }
      for (; v < stop; ++v) {
        const Contribution x = k(v);
        sum[0] += x.value;
        largest[0] = larger(x.magnitude, largest[0]);
      }
      for (int l = 0; l < kLanes; ++l) add({sum[l], largest[l]}, all);
    }
    return all;
  }
  /// CpuFieldExecutor::histogram()
  template <class Kernel>
  void histogram(int n, const Kernel& kernel, int* count) const {
    constexpr int kIndicesPerHistogramJob = 16 * kIndicesPerJob;
    std::mutex mutex;
    run_jobs((n + kIndicesPerHistogramJob - 1) / kIndicesPerHistogramJob, [&](int job) {
      std::vector<int> own(kBins);
      for (int v = job * kIndicesPerHistogramJob; v < std::min(n, (job + 1) * kIndicesPerHistogramJob); ++v) {
        const int bin = kernel(v);
        if (bin >= 0 && bin < kBins) ++own[bin];
      }
      const std::lock_guard lock(mutex);
      for (int b = 0; b < kBins; ++b) count[b] += own[b];
    });
  }
  /// Runs kernel(block) by one block of the threads; the others wait.
  template <class Kernel>
  void by_one_block(const Kernel& kernel) const {
    kernel(SerialBlock{});
  }
  /// Whether this is the first thread.
  bool is_first() const { return true; }
  /// Reports the progress of an iteration whose error decreases from `first` to `tolerance`.
  void report(float first, float error, double tolerance) const {
    if (progress_ && error > 0) progress_(static_cast<float>(std::log(first / error) / std::log(first / tolerance)));
  }

 private:
  static int rows_of_job(const BoxGrid& grid) { return std::max(1, kIndicesPerJob / std::max(1, grid.size[0])); }
  static void add(const Totals& x, Totals& all) {
    all.sum += x.sum;
    all.largest = larger(x.largest, all.largest);
  }
  template <class Job>
  void run_jobs(int jobs, const Job& job) const {
    if (jobs == 1)
      job(0);
    else
      run_(jobs, job);
  }
  template <class Job>
  Totals totals_of_jobs(int jobs, const Job& job) const {
    std::vector<Totals> parts(jobs);
    run_jobs(jobs, [&](int j) { parts[j] = job(j); });
    Totals all;
    for (const Totals& part : parts) add(part, all);
    return all;
  }
  const RunJobs& run_;
  const ReportProgress& progress_;
};

/// Executor on the CPU. Results do not depend on the number of threads of `run`.
class CpuFieldExecutor {
 public:
  static constexpr bool kHostMemory = true;  ///< whether the host can read arrays
  /// Cells that each_lanes() processes together. GCC unrolls loops over 16 or fewer instead of vectorising them.
  static constexpr int kLanes = 32;

  explicit CpuFieldExecutor(RunJobs run = run_serially()) : run_(std::move(run)) {}

  /// Array in the memory of the executor, with undefined values at first; can be moved, not copied. `pad` values before
  /// data() and after data() + size() are 0, for kernels that read neighbours of all cells.
  template <class T>
  class Array {
   public:
    Array() = default;
    Array(std::size_t size, std::size_t pad)
        : size_(size), pad_(pad), values_(std::make_unique_for_overwrite<T[]>(size + 2 * pad)) {
      if (pad != 0) std::memset(static_cast<void*>(values_.get()), 0, bytes());
#ifndef NDEBUG
      if (pad == 0 && size != 0) std::memset(static_cast<void*>(values_.get()), 0xa5, bytes());  // shows in tests
#endif
    }
    T* data() const { return values_.get() + pad_; }
    std::size_t size() const { return size_; }
    std::size_t bytes() const { return (size_ + 2 * pad_) * sizeof(T); }
    Array(Array&& other) noexcept
        : size_(std::exchange(other.size_, 0)), pad_(std::exchange(other.pad_, 0)), values_(std::move(other.values_)) {}
    Array& operator=(Array&& other) noexcept {
      size_ = std::exchange(other.size_, 0);
      pad_ = std::exchange(other.pad_, 0);
      values_ = std::move(other.values_);
      return *this;
    }

   private:
    std::size_t size_ = 0, pad_ = 0;
    std::unique_ptr<T[]> values_;
  };

  /// Returns an array of undefined values.
  template <class T>
  Array<T> array(std::size_t size) const {
    return {size, 0};
  }
  /// Returns an array of a value for each cell, all 0, with a plane of zeros before and after.
  template <class T>
  Array<T> padded(const BoxGrid& grid) const {
    return {static_cast<std::size_t>(grid.count()), static_cast<std::size_t>(grid.plane())};
  }
  template <class T>
  Array<T> copy_of(std::span<const T> from) const {
    Array<T> to(from.size(), 0);
    upload(from, to.data());
    return to;
  }
  template <class T>
  void upload(std::span<const T> from, T* to) const {
    if (!from.empty()) std::memcpy(to, from.data(), from.size_bytes());
  }
  /// Waits for all earlier work and for the copy.
  template <class T>
  void download(const T* from, std::span<T> to) const {
    if (!to.empty()) std::memcpy(to.data(), from, to.size_bytes());
  }
  /// Download in progress.
  template <class T>
  using Fetched = std::vector<T>;
  /// Begins a download after all earlier work; does not wait. Downloads that have begun must not exceed 128 KiB.
  template <class T>
  Fetched<T> fetch(const T* from, std::size_t count) const {
    return {from, from + count};
  }
  /// Waits for a download, not for later work.
  template <class T>
  void receive(const Fetched<T>& fetched, std::span<T> to) const {
    std::copy(fetched.begin(), fetched.end(), to.begin());
  }
  template <class T>
  void copy(const T* from, T* to, std::size_t count) const {
    if (count != 0) std::memcpy(to, from, count * sizeof(T));
  }
  template <class T>
  void clear(T* at, std::size_t count) const {
    if (count != 0) std::memset(at, 0, count * sizeof(T));
  }

  /// Calls kernel(v) for all 0 <= v < n, in any order and in parallel.
  template <class Kernel>
  void each(int n, const Kernel& kernel) const {
    for_each_index(run_, n, kernel);
  }
  /// Calls kernel(CellAt) for all cells of a grid. With kCellsInOrder, a thread visits the cells of a row in ascending
  /// order.
  static constexpr bool kCellsInOrder = true;
  template <class Kernel>
  void each_cell(const BoxGrid& grid, const Kernel& kernel) const {
    simplexseg::each_cell(grid_of_all(), grid, kernel);
  }
  /// Calls kernel.run<kLanes>(v) for groups of consecutive cells, so that loops over lanes are vectorised on the CPU.
  template <class Kernel>
  void each_lanes(int n, const Kernel& kernel) const {
    constexpr int kGroups = kIndicesPerJob / kLanes;
    const int groups = n / kLanes;
    run_((groups + kGroups - 1) / kGroups, [&](int job) {
      const Kernel own = kernel;
      for (int g = job * kGroups; g < std::min(groups, (job + 1) * kGroups); ++g) own.template run<kLanes>(g * kLanes);
    });
    for (int v = groups * kLanes; v < n; ++v) kernel.template run<1>(v);
  }
  /// Calls kernel.run<kLanes>(CellAt) for groups of cells of a row. The last cells of a row may be visited twice.
  template <class Kernel>
  void each_cell_lanes(const BoxGrid& grid, const Kernel& kernel) const {
    grid_of_all().each_row(grid, [&](int j, int k) {
      const Kernel own = kernel;
      const auto run_by = [&]<int kCount>(std::integral_constant<int, kCount>) {
        for (int i = 0; i < grid.size[0]; i += kCount)
          own.template run<kCount>(cell_at(grid, std::min(i, grid.size[0] - kCount), j, k));
      };
      constexpr int kFewLanes = 8;
      if (grid.size[0] >= kLanes)
        run_by(std::integral_constant<int, kLanes>{});
      else if (grid.size[0] >= kFewLanes)
        run_by(std::integral_constant<int, kFewLanes>{});
      else
        run_by(std::integral_constant<int, 1>{});
    });
  }
  /// Runs kernel(CpuGrid) by all threads; it may report its progress on the thread of the caller.
  template <class Kernel>
  void all(const Kernel& kernel, const ReportProgress& progress = {}) const {
    kernel(CpuGrid(run_, progress));
  }
  /// Calls kernel(block, b) for all 0 <= b < count, each by its own block, in any order and in parallel.
  template <class Kernel>
  void blocks(int count, const Kernel& kernel) const {
    constexpr int kBlocksPerJob = 4;
    run_((count + kBlocksPerJob - 1) / kBlocksPerJob, [&](int job) {
      std::array<float, Kernel::kScratch> scratch;
      for (int b = job * kBlocksPerJob; b < std::min(count, (job + 1) * kBlocksPerJob); ++b)
        kernel(SerialBlock{scratch.data()}, b);
    });
  }
  /// Writes the sums of kernel(v), Summands<kCount>, over all 0 <= v < n, added in double in a fixed order.
  template <class Kernel>
  void sums_into(int n, const Kernel& kernel, double* to) const {
    using Sums = SumsOf<decltype(kernel(0))::kCount>;
    std::vector<Sums> parts((n + kIndicesPerJob - 1) / kIndicesPerJob);
    run_(static_cast<int>(parts.size()), [&](int job) {
      Sums sums{};
      for (int v = job * kIndicesPerJob; v < std::min(n, (job + 1) * kIndicesPerJob); ++v) add(kernel(v), sums);
      parts[job] = sums;
    });
    Sums all{};
    for (const Sums& part : parts)
      for (std::size_t s = 0; s < std::size(all.values); ++s) all.values[s] += part.values[s];
    std::copy(std::begin(all.values), std::end(all.values), to);
  }
  /// Adds to count[b] the number of v, 0 <= v < n, for which kernel(v) is b; values outside 0 .. kBins - 1 are omitted.
  template <class Kernel>
  void histogram(int n, const Kernel& kernel, int* count) const {
    grid_of_all().histogram(n, kernel, count);
  }

 private:
  CpuGrid grid_of_all() const { return {run_, no_progress_}; }

  RunJobs run_;
  ReportProgress no_progress_;
};

}  // namespace simplexseg
