// SPDX-License-Identifier: Apache-2.0
#include "core/quantile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "field/find_value.h"

namespace simplexseg {
namespace {

TEST(Quantile, IsTheValueOfItsRank) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const float infinite = std::numeric_limits<float>::infinity();
  for (const int count : {1, 2, 17, 511, 512, 513, 700, 5000})
    for (const std::string kind : {"normal", "far apart", "few different", "alike", "one far out", "one infinite"}) {
      std::vector<float> values(count);
      for (float& x : values) {
        const double z = normal(random);
        x = static_cast<float>(kind == "far apart"       ? std::exp(9 * z)
                               : kind == "few different" ? std::round(z)
                               : kind == "alike"         ? 3
                                                         : z);
      }
      if (kind == "one far out") values[count / 2] = 3e38f;
      if (kind == "one infinite") values[count / 2] = -infinite;
      std::vector<float> sorted = values;
      std::sort(sorted.begin(), sorted.end());
      for (const double share : {0.0, 0.01, 0.25, 0.5, 0.9, 1.0})
        ASSERT_EQ(quantile(values, share), sorted[static_cast<std::size_t>(share * (count - 1))])
            << count << " " << kind << " " << share;
    }
}

TEST(FindOther, IsTheFirstThatDiffers) {
  for (int different = 0; different <= 40; ++different)
    for (const int first : {0, 1, 7, 8, 20}) {
      std::vector<std::uint8_t> values(40, 5);
      if (different < 40) values[different] = 6;
      EXPECT_EQ(find_other(values, std::uint8_t{5}, first, 40), different < first ? 40 : different);
      EXPECT_EQ(find_other(values, std::uint8_t{5}, first, 30), different < first || different > 30 ? 30 : different);
    }
}

}  // namespace
}  // namespace simplexseg
