// SPDX-License-Identifier: Apache-2.0
#include "field/mark_measures.h"

#include <cmath>

#include "field/quantile.h"

namespace simplexseg {
namespace {

constexpr std::array kLeastDeviation{0.01f, 0.03f, 0.03f};  // of the image's range; of the smoothed ones' deviation

}  // namespace

Strangeness strangeness_among(std::array<std::vector<float>, 3>& values) {
  Strangeness strangeness;
  for (std::size_t l = 0; l < values.size(); ++l) {
    if (values[l].empty()) continue;
    const float middle = strangeness.middle[l] = quantile(values[l], 0.5);
    for (float& x : values[l]) x = std::fabs(x - middle);
    strangeness.per_deviation[l] =
        1 / (static_cast<float>(kDeviationsOfMedian) * quantile(values[l], 0.5) + kLeastDeviation[l]);
  }
  return strangeness;
}

}  // namespace simplexseg
