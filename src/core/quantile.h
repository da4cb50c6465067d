// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

namespace simplexseg {

/// Standard deviation of a normal distribution per median of |x - median|.
inline constexpr double kDeviationsOfMedian = 1.4826;

/// Order statistic at rank floor(share (n - 1)), counted from 0, of n >= 1 values, which are reordered. For many
/// values, a histogram first selects those near the rank, which is several times faster than std::nth_element().
template <class T>
T quantile(std::vector<T>& values, double share) {
  static_assert(std::is_floating_point_v<T>);
  constexpr std::size_t many = 512;
  constexpr int bins = 1024;  // of the histogram
  auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  const auto nth_of = [](std::vector<T>& some, std::ptrdiff_t nth) {
    std::nth_element(some.begin(), some.begin() + nth, some.end());
    return some[nth];
  };
  if (values.size() < many) return nth_of(values, rank);
  constexpr std::size_t lanes = 16;  // independent comparisons
  std::array<T, lanes> lows, highs;
  lows.fill(values[0]), highs.fill(values[0]);
  const auto compare = [&](std::size_t lane, T x) {
    lows[lane] = x < lows[lane] ? x : lows[lane];
    highs[lane] = x > highs[lane] ? x : highs[lane];
  };
  std::size_t next = 0;
  for (; next + lanes <= values.size(); next += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) compare(lane, values[next + lane]);
  for (; next < values.size(); ++next) compare(0, values[next]);
  const T low = std::ranges::min(lows), high = std::ranges::max(highs);
  const T scale = bins / (high - low);
  if (!(scale > 0 && scale <= std::numeric_limits<T>::max())) return nth_of(values, rank);  // all equal, or not finite
  // Monotonic in x.
  const auto bin_of = [=](T x) {
    const T at = (x - low) * scale;
    return at < bins - 1 ? static_cast<int>(at) : bins - 1;
  };
  std::array<int, bins> count{};
  for (const T x : values) ++count[bin_of(x)];
  int bin = 0;
  while (rank >= count[bin]) rank -= count[bin++];
  std::vector<T> in_bin;
  in_bin.reserve(count[bin]);
  for (const T x : values)
    if (bin_of(x) == bin) in_bin.push_back(x);
  return nth_of(in_bin, rank);
}

}  // namespace simplexseg
