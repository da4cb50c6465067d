// SPDX-License-Identifier: Apache-2.0
#include "model/learning_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "organ_family.h"

namespace simplexseg {
namespace {

OrganModel model_with_errors(const std::vector<UnseenError>& errors) {
  OrganModel model;
  for (const UnseenError& one : errors) {
    TrainedCase& added = model.cases.emplace_back();
    added.error_cases = one.cases, added.error_mm = one.error_mm;
  }
  return model;
}

TEST(LearningCurve, RecoversLimitAndSlopeInSpiteOfAnOutlier) {
  std::vector<UnseenError> errors{{0, 0}};  // the first case has no error
  for (int n = 1; n <= 30; ++n) errors.push_back({n, 0.5 + 2.0 / n + (n % 2 ? 0.01 : -0.01)});
  errors[12].error_mm = 9;
  const LearningCurve curve = learning_curve(model_with_errors(errors));
  ASSERT_TRUE(curve.fit);
  EXPECT_NEAR(curve.fit->limit_mm, 0.5, 0.02);
  EXPECT_NEAR(curve.fit->slope_mm, 2, 0.1);
  EXPECT_NEAR(*curve.fit->cases_within(0.1), 40, 3);
  EXPECT_EQ(curve.points.size(), 30u);
}

TEST(LearningCurve, JoinsErrorsOfEqualNumbersAndNeedsThreeNumbers) {
  const LearningCurve two = learning_curve(model_with_errors({{4, 3}, {4, 4}, {5, 1}}));
  ASSERT_EQ(two.points.size(), 2u);
  EXPECT_NEAR(two.points[0].error_mm, std::sqrt(12.5), 1e-12);
  EXPECT_FALSE(two.fit);
  const LearningCurve rising = learning_curve(model_with_errors({{1, 1}, {2, 1.5}, {4, 2}}));
  ASSERT_TRUE(rising.fit) << "an error that grows by chance has no slope";
  EXPECT_EQ(rising.fit->slope_mm, 0);
  EXPECT_EQ(*rising.fit->cases_within(0.1), 1);
}

TEST(LearningCurve, IsMeasuredInTrainingForFewerCases) {
  const std::vector<ModelCase> cases = make_organs(0, 9);
  const TrainingSettings settings{.vertices = 200, .modes = 20, .measure_curve = true};
  const OrganModel model = train_model(register_cases(cases, settings, run_serially()), settings, run_serially());
  std::map<int, int> tests;
  for (const UnseenError& one : model.curve) ++tests[one.cases];
  EXPECT_EQ(tests, (std::map<int, int>{{1, 8}, {2, 7}, {4, 5}}));
  const LearningCurve curve = learning_curve(model);
  ASSERT_TRUE(curve.fit);
  EXPECT_LT(curve.points.back().error_mm, curve.points.front().error_mm);
}

}  // namespace
}  // namespace simplexseg
