// SPDX-License-Identifier: Apache-2.0
// What the evidence field of many threads runs on (docs/adr/0032-field-on-a-device.md). Its parts are templates
// over an executor, which owns arrays in its memory and runs kernels over them: functors, or lambdas that copy what
// they take
// ([=] SIMPLEXSEG_KERNEL), which read and write arrays by pointers. On a device that is CudaFieldExecutor
// (gpu/cuda_field_executor.h); here is the one of the tests, which needs no device.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/vec3.h"
#include "evidence/padded_array.h"

#ifdef __CUDACC__
#define SIMPLEXSEG_KERNEL __host__ __device__
#define SIMPLEXSEG_UNROLL_ALL _Pragma("unroll")  // so that arrays with these indices are registers
#else
#define SIMPLEXSEG_KERNEL
#define SIMPLEXSEG_UNROLL_ALL
#endif

namespace simplexseg {

/// A team of one thread. A kernel for a team is run by a whole block of threads on a device: it shares out its loops
/// (v = team.thread; v < n; v += team.threads), and waits for what the others wrote by team.sync(), or by team.any(x),
/// which says whether x is true for one of them. What a kernel of several teams asks for in kScratch, floats, is there
/// for each team by itself.
struct SerialBlock {
  static constexpr int thread = 0, threads = 1;
  float* scratch = nullptr;
  SIMPLEXSEG_HD void sync() const {}
  SIMPLEXSEG_HD bool any(bool x) const { return x; }
  /// kernel(team), by a team of a few of its threads, for what is too little for all; the others wait.
  template <class Kernel>
  SIMPLEXSEG_HD void warp(const Kernel& kernel) const {
    kernel(*this);
  }
};

/// Bins of histogram().
inline constexpr int kBins = 2048;

/// Of all values of a pass: what is added in double, in an order that is always the same, and the largest.
struct Totals {
  double sum = 0;
  float largest = 0;
};
/// A value's part of them; `size` >= 0.
struct OfTotals {
  float value, size;
};

/// Values that are added one by one, at most kMostSums.
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

/// A team of all threads that the executor has, for algorithms of many passes over what lies in its memory; here it is
/// one. Each pass ends when all threads have ended it. What each thread knows beside that memory must be the same.
struct SerialGrid {
  /// kernel(v) for all 0 <= v < n.
  template <class Kernel>
  SIMPLEXSEG_HD void each(int n, const Kernel& kernel) const {
    for (int v = 0; v < n; ++v) kernel(v);
  }
  /// Of kernel(v), OfTotals, for all 0 <= v < n.
  template <class Kernel>
  SIMPLEXSEG_HD Totals totals(int n, const Kernel& kernel) const {
    Totals all;
    for (int v = 0; v < n; ++v) {
      const OfTotals x = kernel(v);
      all.sum += x.value;
      all.largest = larger(x.size, all.largest);
    }
    return all;
  }
  /// As SerialExecutor::histogram().
  template <class Kernel>
  SIMPLEXSEG_HD void histogram(int n, const Kernel& kernel, int* count) const {
    for (int v = 0; v < n; ++v) {
      const int bin = kernel(v);
      if (bin >= 0 && bin < kBins) ++count[bin];
    }
  }
  /// kernel(team), by a part of the threads, which is a team as above, while the others wait.
  template <class Kernel>
  SIMPLEXSEG_HD void some(const Kernel& kernel) const {
    kernel(SerialBlock{});
  }
  /// True for one of the threads.
  SIMPLEXSEG_HD bool is_first() const { return true; }
};

/// The executor that runs one index after another, on the thread of the caller.
class SerialExecutor {
 public:
  /// Values in the executor's memory; moved, not copied. The first `pad` values before data() and the last ones behind
  /// data() + size() are there, too, and 0, for kernels that read neighbours without asking where they are.
  template <class T>
  class Array {
   public:
    Array() = default;
    Array(std::size_t size, std::size_t pad) : size_(size), pad_(pad), values_(size + 2 * pad) {
      if (pad == 0 && size != 0) std::memset(values_.data(), 0xa5, size * sizeof(T));  // nothing is promised of it
    }
    Array(Array&&) noexcept = default;
    Array& operator=(Array&&) noexcept = default;
    T* data() const { return const_cast<T*>(values_.data()) + pad_; }
    std::size_t size() const { return size_; }
    std::size_t bytes() const { return values_.size() * sizeof(T); }

   private:
    std::size_t size_ = 0, pad_ = 0;
    std::vector<T> values_;
  };

  /// So many values, of which nothing is promised.
  template <class T>
  Array<T> array(std::size_t size) const {
    return {size, 0};
  }
  /// A value for each voxel, all 0, and zeros around as PaddedArray has them.
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
  /// Returns when the values are there.
  template <class T>
  void download(const T* from, std::span<T> to) const {
    if (!to.empty()) std::memcpy(to.data(), from, to.size_bytes());
  }
  /// Values that are on their way to the host.
  template <class T>
  using Fetched = std::vector<T>;
  /// Begins to download what is there once all that was begun before has ended; does not wait. Few may be on their way
  /// at a time, together less than 128 KiB.
  template <class T>
  Fetched<T> fetch(const T* from, std::size_t count) const {
    return {from, from + count};
  }
  /// Waits for them, and for nothing that was begun after them.
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

  /// kernel(v) for all 0 <= v < n, in any order and at the same time.
  template <class Kernel>
  void each(int n, const Kernel& kernel) const {
    for (int v = 0; v < n; ++v) kernel(v);
  }
  /// kernel(team), by a team of all threads.
  template <class Kernel>
  void all(const Kernel& kernel) const {
    kernel(SerialGrid{});
  }
  /// kernel(team, t) for all 0 <= t < count, each by a team of its own; they run in any order and at the same time.
  template <class Kernel>
  void teams(int count, const Kernel& kernel) const {
    std::vector<float> scratch(Kernel::kScratch);
    for (int t = 0; t < count; ++t) kernel(SerialBlock{scratch.data()}, t);
  }
  /// Writes the sums of the floats of kernel(v), Summands<kCount>, over all 0 <= v < n, added in double in an order
  /// that is always the same.
  template <class Kernel>
  void sums_into(int n, const Kernel& kernel, double* to) const {
    SumsOf<decltype(kernel(0))::kCount> sums{};
    for (int v = 0; v < n; ++v) add(kernel(v), sums);
    std::copy(std::begin(sums.is), std::end(sums.is), to);
  }
  /// Adds to count[b] how many of kernel(v), 0 <= v < n, are b; those that are not in 0 .. kBins - 1 are left out.
  template <class Kernel>
  void histogram(int n, const Kernel& kernel, int* count) const {
    SerialGrid{}.histogram(n, kernel, count);
  }
};

/// A list in the executor's memory that is written anew now and then, and grows.
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

/// One that was fetched; waits for it.
template <class T, class Executor>
T received(const Executor& executor, const typename Executor::template Fetched<T>& fetched) {
  T value;
  executor.receive(fetched, std::span<T>(&value, 1));
  return value;
}

}  // namespace simplexseg
