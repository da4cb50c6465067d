// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

namespace simplexseg {

/// Standard deviations of a normal distribution in its median of |x - median|.
inline constexpr double kDeviationsOfMedian = 1.4826;

/// The value below which this share of them lies, one of them; reorders. There must be one. Of many the ones about it
/// are found by a histogram first, several times sooner.
template <class T>
T quantile(std::vector<T>& values, double share) {
  static_assert(std::is_floating_point_v<T>);
  constexpr std::size_t many = 512;
  constexpr int bins = 1024;
  auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  const auto nth_of = [](std::vector<T>& some, std::ptrdiff_t nth) {
    std::nth_element(some.begin(), some.begin() + nth, some.end());
    return some[nth];
  };
  if (values.size() < many) return nth_of(values, rank);
  constexpr std::size_t lanes = 16;  // what one compares need not wait for what another did
  std::array<T, lanes> lows, highs;
  lows.fill(values[0]), highs.fill(values[0]);
  const auto take = [&](std::size_t lane, T x) {
    lows[lane] = x < lows[lane] ? x : lows[lane];
    highs[lane] = x > highs[lane] ? x : highs[lane];
  };
  std::size_t next = 0;
  for (; next + lanes <= values.size(); next += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) take(lane, values[next + lane]);
  for (; next < values.size(); ++next) take(0, values[next]);
  const T low = std::ranges::min(lows), high = std::ranges::max(highs);
  const T scale = bins / (high - low);
  if (!(scale > 0 && scale <= std::numeric_limits<T>::max())) return nth_of(values, rank);  // all alike, or not finite
  // Rises with x.
  const auto bin_of = [=](T x) {
    const T at = (x - low) * scale;
    return at < bins - 1 ? static_cast<int>(at) : bins - 1;
  };
  std::array<int, bins> count{};
  for (const T x : values) ++count[bin_of(x)];
  int bin = 0;
  while (rank >= count[bin]) rank -= count[bin++];
  std::vector<T> about;
  about.reserve(count[bin]);
  for (const T x : values)
    if (bin_of(x) == bin) about.push_back(x);
  return nth_of(about, rank);
}

}  // namespace simplexseg
