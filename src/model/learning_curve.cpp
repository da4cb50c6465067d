// SPDX-License-Identifier: Apache-2.0
#include "model/learning_curve.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

namespace simplexseg {
namespace {

constexpr int kHuberIterations = 30;
constexpr double kHuber = 1.345;       ///< limit of a residual with full weight, robust deviations
constexpr double kDeviation = 1.4826;  ///< of a normal distribution, median absolute deviations
constexpr std::size_t kLeastNumbers = 3;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Robust fit of error = limit + slope / cases, both at least 0.
LearningCurve::Fit fit_curve(const std::vector<UnseenError>& points) {
  LearningCurve::Fit fit{0, 0};
  std::vector<double> weights(points.size(), 1);
  for (int k = 0; k < kHuberIterations; ++k) {
    Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Eigen::Vector2d row(1, 1.0 / points[p].cases);
      matrix += weights[p] * row * row.transpose();
      right += weights[p] * points[p].error_mm * row;
    }
    const Eigen::Vector2d solution = matrix.ldlt().solve(right);
    fit = {solution[0], solution[1]};
    if (fit.slope_mm < 0) fit = {right[0] / matrix(0, 0), 0};
    if (fit.limit_mm < 0) fit = {0, right[1] / matrix(1, 1)};
    std::vector<double> residuals;
    residuals.reserve(points.size());
    for (const UnseenError& p : points) residuals.push_back(std::abs(p.error_mm - fit.at(p.cases)));
    const double deviation = std::max(kDeviation * median(residuals), 1e-9);
    for (std::size_t p = 0; p < points.size(); ++p)
      weights[p] = std::min(1.0, kHuber * deviation / std::max(residuals[p], 1e-12));
  }
  return fit;
}

}  // namespace

std::optional<int> LearningCurve::Fit::cases_within(double share) const {
  if (limit_mm <= 0) return std::nullopt;
  return std::max(1, static_cast<int>(std::ceil(slope_mm / (share * limit_mm) - 1e-9)));
}

LearningCurve learning_curve(const OrganModel& model) {
  std::vector<UnseenError> single = model.curve;
  for (const TrainedCase& one : model.cases)
    if (one.error_cases > 0) single.push_back({one.error_cases, one.error_mm});
  std::map<int, std::pair<double, int>> sums;
  for (const UnseenError& p : single) {
    auto& [squares, count] = sums[p.cases];
    squares += p.error_mm * p.error_mm, ++count;
  }
  LearningCurve curve;
  for (const auto& [cases, sum] : sums) curve.points.push_back({cases, std::sqrt(sum.first / sum.second)});
  if (sums.size() >= kLeastNumbers) curve.fit = fit_curve(single);
  return curve;
}

}  // namespace simplexseg
