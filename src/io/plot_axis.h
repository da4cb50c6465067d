// SPDX-License-Identifier: Apache-2.0
// Where an axis of a plot begins and ends, and what stands at its ticks.
#pragma once
#include <string>
#include <vector>

namespace simplexseg {

struct PlotAxis {
  struct Tick {
    double at;          ///< share of the axis, 0..1
    std::string label;  ///< empty: a minor tick
  };
  bool log = false;
  double low = 0, high = 1;  ///< on a log axis the logarithms to base 10
  std::vector<Tick> ticks;

  /// Whether the value has a place on an axis of this kind.
  bool shows(double value) const;
  /// Share of the axis, 0..1.
  double share(double value) const;
};

/// An axis that shows all values that are finite (and > 0 on a log axis), with a little room at both ends, and ticks
/// for about `labels` labels.
PlotAxis make_axis(const std::vector<double>& values, bool log, int labels);

}  // namespace simplexseg
