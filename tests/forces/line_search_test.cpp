// SPDX-License-Identifier: Apache-2.0
// Peak of a search: choice among equal values, and the adjacent values.
#include "forces/line_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "forces/lanes.h"

namespace simplexseg {
namespace {

PeakOf<float> peak_of(const std::vector<float>& values) {
  auto kept = OneLane{}.scratch<2 * kMaxSearch + 1>(0);
  return find_peak(OneLane{}, kept, static_cast<int>(values.size() / 2), [&](int k) { return values[k]; });
}

TEST(FindPeak, TiesGoToTheMiddleThenToTheLowerShift) {
  EXPECT_EQ(peak_of({1, 2, 3, 2, 9, 1, 1}).shift, 1) << "the largest";
  EXPECT_EQ(peak_of({9, 1, 1, 1, 1, 9, 1}).shift, 2) << "the nearer";
  EXPECT_EQ(peak_of({1, 9, 1, 1, 9, 1, 1}).shift, 1) << "the nearer";
  EXPECT_EQ(peak_of({1, 9, 1, 1, 1, 9, 1}).shift, -2) << "the lower";
  EXPECT_EQ(peak_of({1, 1, 9, 1, 9, 1, 1}).shift, -1) << "the lower";
  EXPECT_EQ(peak_of({5, 5, 5, 5, 5, 5, 5}).shift, 0) << "the middle";
}

TEST(FindPeak, NaNValuesAreIgnored) {
  const PeakOf<float> peak = peak_of({NAN, NAN, 2, 1, 3, NAN, 7});
  EXPECT_EQ(peak.shift, 3);
  EXPECT_TRUE(std::isnan(peak.left));
  EXPECT_TRUE(std::isnan(peak.right)) << "no value beyond the end";
  EXPECT_EQ(peak.offset(), 3);
  const PeakOf<float> within = peak_of({0, 1, 4, 2, 0, 0, 0});
  EXPECT_EQ(within.left, 1);
  EXPECT_EQ(within.right, 2);
  EXPECT_NEAR(within.offset(), -1 + 0.1, 1e-6);
}

}  // namespace
}  // namespace simplexseg
