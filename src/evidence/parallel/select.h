// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include "core/atomics.h"
#include "evidence/parallel/executor.h"

namespace simplexseg {

/// What quantile() (evidence/quantile.h) gives for all value(v) >= 0, 0 <= v < n; those below 0 are left out. Nothing
/// with fewer than `least_count` of them. By histograms of the floats' bits, eleven at a time.
template <class Executor, class Value>
std::optional<float> quantile_of(const Executor& executor, int n, const Value& value, double share,
                                 int least_count = 1) {
  auto counts = executor.template array<int>(kBins);
  std::vector<int> bins(kBins);
  std::uint32_t found = 0;
  long rank = 0;
  for (const int shift : {21, 10, 0}) {
    const int width = shift == 0 ? 10 : 11;
    const std::uint32_t above = static_cast<std::uint32_t>(shift + width), prefix = found;
    executor.clear(counts.data(), kBins);
    executor.histogram(
        n,
        [=] SIMPLEXSEG_KERNEL(int v) {
          const float x = value(v);
          if (!(x >= 0)) return -1;
          const std::uint32_t bits = bits_of(x + 0.0f);  // no -0
          if (above < 32 && bits >> above != prefix >> above) return -1;
          return static_cast<int>(bits >> shift & ((1u << width) - 1));
        },
        counts.data());
    executor.download(counts.data(), std::span<int>(bins));
    if (shift == 21) {
      const long count = std::accumulate(bins.begin(), bins.end(), 0L);
      if (count == 0 || count < least_count) return std::nullopt;
      rank = static_cast<long>(share * static_cast<double>(count - 1));
    }
    int bin = 0;
    while (rank >= bins[bin]) rank -= bins[bin++];
    found |= static_cast<std::uint32_t>(bin) << shift;
  }
  float x;
  std::memcpy(&x, &found, sizeof x);
  return x;
}

}  // namespace simplexseg
