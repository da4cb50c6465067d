// SPDX-License-Identifier: Apache-2.0
// How two label volumes are compared, one entry for each number: what it is called, means and is written as.
#pragma once
#include <span>
#include <string_view>

#include "image/metrics.h"
#include "image/surface_metrics.h"

namespace simplexseg {

constexpr double kUsualToleranceMm = 1;  ///< of the surface Dice where nobody asks for another

/// Everything that is known of how well two masks agree.
struct MaskComparison {
  Agreement voxels;
  SurfaceAgreement surfaces;
};
/// Throws Error as compare() and compare_surfaces().
MaskComparison compare_masks(const Mask& reference, const Mask& test, double tolerance_mm = kUsualToleranceMm);

struct Metric {
  const char* key;         ///< in JSON and CSV
  const char* title;       ///< for people, unit included
  int decimals;            ///< for people
  const char* definition;  ///< one line; formulas are in docs/mathematics.md, section 5
  double (*value)(const MaskComparison&);
};
std::span<const Metric> metric_list();
/// The one with this key, which must be there.
const Metric& metric_of(std::string_view key);

}  // namespace simplexseg
