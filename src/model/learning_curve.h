// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "model/organ_model.h"

namespace simplexseg {

/// Errors of models of an organ on cases that they had not seen, against their number of cases.
struct LearningCurve {
  std::vector<UnseenError> points;  ///< root mean square for each number of cases, in increasing order
  /// Fitted error: limit + slope / cases.
  struct Fit {
    double limit_mm, slope_mm;
    double at(double cases) const { return limit_mm + slope_mm / cases; }
    /// Number of cases whose error is within a share of the limit; nothing if the limit is 0.
    std::optional<int> cases_within(double share) const;
  };
  std::optional<Fit> fit;  ///< nothing for fewer than three numbers of cases
};

/// Curve from the errors of the cases of a model (TrainedCase::error_mm) and OrganModel::curve. The fit limits the
/// influence of outliers (Huber 1964).
LearningCurve learning_curve(const OrganModel& model);

}  // namespace simplexseg
