// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "core/atomics.h"
#include "field/parallel/executor.h"

namespace simplexseg {

/// What is known of the value of a rank: its upper bits, and its rank among the values that share them.
struct Selected {
  long long rank;
  std::uint32_t bits;
  bool found;
  SIMPLEXSEG_HD float value_or(float otherwise) const { return found ? float_of(bits) : otherwise; }
};

/// The bin that holds the value of the rank; of the first bins, the rank of `share`. By one team.
struct SelectBin {
  static constexpr int kGroups = 64, kOfGroup = kBins / kGroups;
  const int* count;  ///< of each bin
  int* of_group;     ///< room for kGroups
  int shift;         ///< where the bin's bits lie
  bool first;
  double share;
  int least_count;
  Selected* selected;

  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team) const {
    for (int g = team.thread; g < kGroups; g += Team::threads) {
      int sum = 0;
      for (int b = 0; b < kOfGroup; ++b) sum += count[g * kOfGroup + b];
      of_group[g] = sum;
    }
    team.sync();
    if (team.thread != 0) return;
    Selected now{};
    if (first) {
      long long all = 0;
      for (int g = 0; g < kGroups; ++g) all += of_group[g];
      now = {static_cast<long long>(share * static_cast<double>(all - 1)), 0, all > 0 && all >= least_count};
    } else {
      now = *selected;
    }
    if (now.found) {
      int bin = 0;
      for (; now.rank >= of_group[bin / kOfGroup]; bin += kOfGroup) now.rank -= of_group[bin / kOfGroup];
      for (; now.rank >= count[bin]; ++bin) now.rank -= count[bin];
      now.bits |= static_cast<std::uint32_t>(bin) << shift;
    }
    *selected = now;
  }
};

/// What quantile() (field/quantile.h) gives for all value(v) >= 0, 0 <= v < n; those below 0 are left out. Not found
/// with fewer than `least_count` of them. By histograms of the floats' bits, eleven at a time; by all threads.
template <class Value>
struct SelectQuantile {
  static constexpr int kPasses = 3, kRoom = kPasses * (kBins + SelectBin::kGroups);
  int n;
  Value value;
  double share;
  int least_count;
  int* room;  ///< kRoom
  Selected* selected;

  template <class All>
  SIMPLEXSEG_KERNEL void operator()(const All& all) const {
    constexpr int shifts[kPasses]{21, 10, 0};
    all.each(kPasses * kBins, Clear{room});
    for (int pass = 0; pass < kPasses; ++pass) {
      int *const count = room + pass * kBins, *const of_group = room + kPasses * kBins + pass * SelectBin::kGroups;
      all.histogram(n, BinOfValue{value, shifts[pass], selected}, count);
      all.some(SelectBin{count, of_group, shifts[pass], pass == 0, share, least_count, selected});
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
    const Selected* so_far;  ///< asked from the second pass on
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
/// Does not wait; what it returns, of one element, is in the executor's memory.
template <class Executor, class Value>
typename Executor::template Array<Selected> select_quantile(const Executor& executor, int n, const Value& value,
                                                            double share, int least_count = 1) {
  const auto room = executor.template array<int>(SelectQuantile<Value>::kRoom);
  auto selected = executor.template array<Selected>(1);
  executor.all(SelectQuantile<Value>{n, value, share, least_count, room.data(), selected.data()});
  return selected;
}

}  // namespace simplexseg
