// SPDX-License-Identifier: Apache-2.0
// Stability study of the evidence field: every case on a backend, and its reports.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "study/field_stability_case.h"

namespace simplexseg {

struct FieldStabilityStudy {
  std::string backend;                   ///< FieldBackend::description
  std::vector<FieldCaseResult> results;  ///< in the order of field_stability_cases()
  int missed() const;                    ///< number of results that differ from the expectation
};
/// Runs the study. `progress` is called before each case and at the end with the completed share in [0, 1].
FieldStabilityStudy study_field_stability(const FieldBackend& backend, const std::function<void(double)>& progress);

/// CSV with a line per case; empty fields were not measured.
std::string field_cases_csv(const FieldStabilityStudy& study);
/// Markdown page with a table of all cases.
std::string field_stability_report(const FieldStabilityStudy& study);

}  // namespace simplexseg
