// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>

#include "core/atomics.h"
#include "evidence/parallel/executor.h"

namespace simplexseg {

/// What is known of the value of a rank: its upper bits, and its rank among the values that share them.
struct Selected {
  long long rank;
  std::uint32_t bits;
  bool found;
};

/// The bin that holds the value of the rank; of the first bins, the rank of `share`. By one team.
struct SelectBin {
  static constexpr int kGroups = 64, kOfGroup = kBins / kGroups;
  static constexpr int kScratch = kGroups;
  const int* count;  ///< of each bin
  int shift;         ///< where the bin's bits lie
  bool first;
  double share;
  int least_count;
  Selected* selected;

  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team, int) const {
    int* const of_group = reinterpret_cast<int*>(team.scratch);
    for (int g = team.thread; g < kGroups; g += Team::threads) {
      int sum = 0;
      for (int b = 0; b < kOfGroup; ++b) sum += count[g * kOfGroup + b];
      of_group[g] = sum;
    }
    team.sync();
    if (team.thread != 0) return;
    Selected now = *selected;
    if (first) {
      long long all = 0;
      for (int g = 0; g < kGroups; ++g) all += of_group[g];
      now = {static_cast<long long>(share * static_cast<double>(all - 1)), 0, all > 0 && all >= least_count};
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

/// What quantile() (evidence/quantile.h) gives for all value(v) >= 0, 0 <= v < n; those below 0 are left out. Nothing
/// with fewer than `least_count` of them. By histograms of the floats' bits, eleven at a time. Waits once.
template <class Executor, class Value>
std::optional<float> quantile_of(const Executor& executor, int n, const Value& value, double share,
                                 int least_count = 1) {
  constexpr int passes = 3, shifts[passes]{21, 10, 0};
  const auto counts = executor.template array<int>(passes * kBins);
  const auto selected = executor.template array<Selected>(1);
  const Selected* const so_far = selected.data();
  executor.clear(counts.data(), counts.size());
  executor.clear(selected.data(), 1);
  for (int pass = 0; pass < passes; ++pass) {
    const int shift = shifts[pass], above = shift == 0 ? 10 : shift + 11;
    int* const count = counts.data() + pass * kBins;
    executor.histogram(
        n,
        [=] SIMPLEXSEG_KERNEL(int v) {
          const float x = value(v);
          if (!(x >= 0)) return -1;
          const std::uint32_t bits = bits_of(x + 0.0f);  // no -0
          if (above < 32 && bits >> above != so_far->bits >> above) return -1;
          return static_cast<int>((above < 32 ? bits & ((1u << above) - 1) : bits) >> shift);
        },
        count);
    executor.teams(1, SelectBin{count, shift, pass == 0, share, least_count, selected.data()});
  }
  const Selected found = value_at(executor, so_far);
  if (!found.found) return std::nullopt;
  return float_of(found.bits);
}

}  // namespace simplexseg
