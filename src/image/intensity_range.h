// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <limits>

namespace simplexseg {

/// Closed range of intensities, in the values of the image (HU for CT).
struct IntensityRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  bool contains(double intensity) const { return low <= intensity && intensity <= high; }
  /// Whether it excludes any intensity.
  bool is_limited() const { return *this != IntensityRange{}; }
  bool operator==(const IntensityRange&) const = default;
};

}  // namespace simplexseg
