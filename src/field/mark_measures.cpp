// SPDX-License-Identifier: Apache-2.0
#include "field/mark_measures.h"

#include <cmath>

#include "core/quantile.h"

namespace simplexseg {
namespace {

constexpr std::array kLeastDeviation{0.01f, 0.03f, 0.03f};  // of the intensity range; of the features' deviation

}  // namespace

IntensityZScore fit_z_score(std::array<std::vector<float>, 3>& values) {
  IntensityZScore z_score;
  for (std::size_t l = 0; l < values.size(); ++l) {
    if (values[l].empty()) continue;
    const float median = z_score.median[l] = quantile(values[l], 0.5);
    for (float& x : values[l]) x = std::fabs(x - median);
    z_score.inverse_deviation[l] =
        1 / (static_cast<float>(kDeviationsOfMedian) * quantile(values[l], 0.5) + kLeastDeviation[l]);
  }
  return z_score;
}

}  // namespace simplexseg
