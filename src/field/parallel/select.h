// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "core/atomics.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// Order statistic so far: upper bits of the value, and its rank among the values that share them.
struct Selected {
  long long rank;
  std::uint32_t bits;
  bool found;
  SIMPLEXSEG_HD float value_or(float otherwise) const { return found ? float_of(bits) : otherwise; }
};

/// Selects the bin that contains the value of the rank, by one block. The first pass computes the rank from `share`.
struct SelectBin {
  static constexpr int kGroups = 64, kOfGroup = kBins / kGroups;
  const int* count;  ///< number of values in each bin
  int* group_count;  ///< workspace of kGroups values
  int shift;         ///< position of the bits of the bin
  bool first;
  double share;
  int least_count;
  Selected* selected;

  template <class Block>
  SIMPLEXSEG_HD void operator()(const Block& block) const {
    for (int g = block.thread; g < kGroups; g += Block::threads) {
      int sum = 0;
      for (int b = 0; b < kOfGroup; ++b) sum += count[g * kOfGroup + b];
      group_count[g] = sum;
    }
    block.sync();
    if (block.thread != 0) return;
    Selected now{};
    if (first) {
      long long all = 0;
      for (int g = 0; g < kGroups; ++g) all += group_count[g];
      now = {static_cast<long long>(share * static_cast<double>(all - 1)), 0, all > 0 && all >= least_count};
    } else {
      now = *selected;
    }
    if (now.found) {
      int bin = 0;
      for (; now.rank >= group_count[bin / kOfGroup]; bin += kOfGroup) now.rank -= group_count[bin / kOfGroup];
      for (; now.rank >= count[bin]; ++bin) now.rank -= count[bin];
      now.bits |= static_cast<std::uint32_t>(bin) << shift;
    }
    *selected = now;
  }
};

/// quantile() (core/quantile.h) of all value(v) >= 0, 0 <= v < n; negative values and NaN are ignored. Not found with
/// fewer than `least_count` values. Radix selection by histograms of eleven bits of the floats, by all threads.
template <class Value>
struct SelectQuantile {
  static constexpr int kPasses = 3, kWorkspace = kPasses * (kBins + SelectBin::kGroups);
  int n;
  Value value;
  double share;
  int least_count;
  int* workspace;  ///< of kWorkspace values
  Selected* selected;

  template <class All>
  SIMPLEXSEG_KERNEL void operator()(const All& all) const {
    constexpr int shifts[kPasses]{21, 10, 0};
    all.each(kPasses * kBins, Clear{workspace});
    for (int pass = 0; pass < kPasses; ++pass) {
      int *const count = workspace + pass * kBins, *const group_count =
                                                       workspace + kPasses * kBins + pass * SelectBin::kGroups;
      all.histogram(n, BinOfValue{value, shifts[pass], selected}, count);
      all.by_one_block(SelectBin{count, group_count, shifts[pass], pass == 0, share, least_count, selected});
    }
  }

 private:
  struct Clear {
    int* at;
    SIMPLEXSEG_HD void operator()(int v) const { at[v] = 0; }
  };
  struct BinOfValue {
    Value value;
    int shift;
    const Selected* so_far;  ///< read from the second pass on
    SIMPLEXSEG_KERNEL int operator()(int v) const {
      const float x = value(v);
      if (!(x >= 0)) return -1;
      const std::uint32_t bits = bits_of(x + 0.0f);  // no -0
      const int above = shift == 0 ? 10 : shift + 11;
      if (above >= 32) return static_cast<int>(bits >> shift);
      if (bits >> above != so_far->bits >> above) return -1;
      return static_cast<int>((bits & ((1u << above) - 1)) >> shift);
    }
  };
};
/// Order statistic in the memory of the executor, an array of one element. Does not wait.
template <class Executor, class Value>
typename Executor::template Array<Selected> select_quantile(const Executor& executor, int n, const Value& value,
                                                            double share, int least_count = 1) {
  const auto workspace = executor.template array<int>(SelectQuantile<Value>::kWorkspace);
  auto selected = executor.template array<Selected>(1);
  executor.all(SelectQuantile<Value>{n, value, share, least_count, workspace.data(), selected.data()});
  return selected;
}

}  // namespace simplexseg
