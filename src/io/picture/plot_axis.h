// SPDX-License-Identifier: Apache-2.0
// Range, ticks and labels of a plot axis.
#pragma once
#include <string>
#include <vector>

namespace simplexseg {

/// Axis of a plot.
struct PlotAxis {
  struct Tick {
    double position;    ///< position along the axis, 0..1
    std::string label;  ///< empty for a minor tick
  };
  bool log = false;
  double low = 0, high = 1;  ///< range; on a log axis, its logarithms to base 10
  std::vector<Tick> ticks;

  /// Whether the value can be shown on this axis: finite, and above 0 on a log axis.
  bool can_show(double value) const;
  /// Position of a value along the axis, 0..1 if the value is in the range.
  double position_of(double value) const;
};

/// Axis that shows all values that are finite (and above 0 on a log axis), with about `labels` labelled ticks. Both
/// ends have a margin, except a linear axis whose smallest value is 0, which starts at 0.
PlotAxis make_axis(const std::vector<double>& values, bool log, int labels);

}  // namespace simplexseg
