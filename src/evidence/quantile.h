// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace simplexseg {

/// Standard deviations of a normal distribution in its median of |x - median|.
inline constexpr double kDeviationsOfMedian = 1.4826;

/// The value below which this share of them lies, one of them; reorders. There must be one.
template <class T>
T quantile(std::vector<T>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace simplexseg
