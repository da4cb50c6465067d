// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/select.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "core/quantile.h"
#include "references.h"

namespace simplexseg {
namespace {

template <class Value>
std::optional<float> quantile_on(int count, const Value& value, double share, int least_count = 1,
                                 const RunJobs& run = run_serially()) {
  const CpuFieldExecutor executor(run);
  const auto selected = select_quantile(executor, count, value, share, least_count);
  const auto found = received<Selected>(executor, executor.fetch(selected.data(), 1));
  return found.found ? std::optional(found.value_or(0)) : std::nullopt;
}

TEST(Select, IsTheValueOfThatRank) {
  std::mt19937 random(5);
  for (const int count : {1, 2, 3, 100, 5000}) {
    std::vector<float> values(count);
    for (float& x : values)
      x = random() % 7 == 0 ? 0.0f : std::ldexp(static_cast<float>(random() % 100000), -int(random() % 30));
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      std::vector<float> copy = values;
      const float expected = quantile(copy, share);
      EXPECT_EQ(quantile_on(
                    count, [&](int v) { return values[v]; }, share)
                    .value(),
                expected);
      EXPECT_EQ(quantile_on(
                    2 * count, [&](int v) { return v % 2 ? -1.0f : values[v / 2]; }, share)
                    .value(),
                expected);
    }
  }
  EXPECT_FALSE(quantile_on(
      10, [](int) { return -1.0f; }, 0.5));
  EXPECT_FALSE(quantile_on(
      10, [](int) { return 1.0f; }, 0.5, 11));
  EXPECT_TRUE(quantile_on(
      10, [](int) { return 1.0f; }, 0.5, 10));
}

TEST(Select, AnyOrderOfJobsGivesTheSameValue) {
  std::mt19937 random(5);
  std::vector<float> values(1000000);
  for (float& x : values) x = static_cast<float>(random() % 100000);
  std::vector<float> copy = values;
  const float expected = quantile(copy, 0.75);
  for (const JobOrder& order : job_orders())
    EXPECT_EQ(quantile_on(
                  1000000, [x = values.data()](int v) { return x[v]; }, 0.75, 1, order.run)
                  .value(),
              expected)
        << order.name;
}

}  // namespace
}  // namespace simplexseg
