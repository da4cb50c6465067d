// SPDX-License-Identifier: Apache-2.0
// Metrics for the comparison of two label volumes: key, title, definition and value of each.
#pragma once
#include <span>
#include <string_view>

#include "image/metrics.h"
#include "image/surface_metrics.h"

namespace simplexseg {

constexpr double kDefaultToleranceMm = 1;  ///< default tolerance of the surface Dice, mm

/// Agreement of two masks: metrics of their voxels and of their surfaces.
struct MaskComparison {
  Agreement voxels;
  SurfaceAgreement surfaces;
};
/// Compares two masks. Throws the errors of compare() and compare_surfaces().
MaskComparison compare_masks(const Mask& reference, const Mask& test, double tolerance_mm = kDefaultToleranceMm);

struct Metric {
  const char* key;         ///< name in JSON and CSV
  const char* title;       ///< heading in printed tables, with the unit
  int decimals;            ///< number of decimals in printed tables
  const char* definition;  ///< one line; formulas are in docs/mathematics.md, section 5
  double (*value)(const MaskComparison&);
};
std::span<const Metric> metric_list();
/// Returns the metric with this key, which must exist.
const Metric& metric_of(std::string_view key);

}  // namespace simplexseg
