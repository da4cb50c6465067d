// SPDX-License-Identifier: Apache-2.0
#include "io/picture/plot_axis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/number_text.h"

namespace simplexseg {
namespace {

/// Text of 10 to the power of n, for n = -2 "0.01" if `plain`, else "10⁻²".
std::string power_text(int n, bool plain) {
  if (plain) return fixed_text(std::pow(10.0, n), std::max(0, -n));
  static const char* const digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = n < 0 ? "10⁻" : "10";
  for (const char c : std::to_string(std::abs(n))) text += digits[c - '0'];
  return text;
}

/// Smallest of 1, 2, 5 and 10 that is at least `ratio`, which is at most 10.
int round_number(double ratio) {
  for (const int number : {1, 2, 5})
    if (ratio <= number) return number;
  return 10;
}

/// Adds ticks at round numbers from `low` to `high`.
void make_round_ticks(PlotAxis& axis, double low, double high, int labels) {
  const double interval = (high - low) / std::max(labels, 1);
  const double power = std::pow(10.0, std::floor(std::log10(interval)));
  const double ratio = interval / power;
  const int lead = round_number(ratio);
  const double between = lead * power;
  const int parts = lead == 2 ? 4 : 5;
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(between) - 1e-9)), 0, 15);
  for (double n = std::ceil(low / between * parts); n <= high / between * parts + 1e-9; ++n) {
    const double value = n * between / parts;
    std::string label;
    if (std::fmod(std::abs(n), parts) == 0) {
      const double shown = n == 0 ? 0.0 : value;
      const bool plain = std::max(std::abs(low), std::abs(high)) < 1e6 && decimals < 7;
      label = plain ? fixed_text(shown, decimals) : general_text(shown, 4);
    }
    axis.ticks.push_back({std::clamp(axis.position_of(value), 0.0, 1.0), label});
  }
}

void make_log_ticks(PlotAxis& axis, int labels) {
  const int first = static_cast<int>(std::floor(axis.low)), last = static_cast<int>(std::ceil(axis.high));
  const int decades = last - first, every = std::max(1, (decades + labels - 1) / labels);
  // A short axis also has labels within each decade. An axis of less than half a decade has ticks at round numbers.
  const double decades_shown = axis.high - axis.low;
  const bool plain = first >= -3 - (decades_shown < 2 ? 3 : 0) && last <= 4;
  if (decades_shown < 0.5) return make_round_ticks(axis, std::pow(10.0, axis.low), std::pow(10.0, axis.high), labels);
  for (int n = first; n <= last; ++n) {
    for (int part = 1; part <= 9; ++part) {
      const double at = (n + std::log10(part) - axis.low) / decades_shown;
      if (at < -1e-9 || at > 1 + 1e-9) continue;
      std::string label;
      if (part == 1) {
        if (n % every == 0) label = power_text(n, plain);
      } else if (every > 2) {
        continue;
      } else if ((decades_shown < 1.7 && (part == 2 || part == 5)) || (decades_shown < 1 && part < 9)) {
        label = general_text(part * std::pow(10.0, n), 6);
      }
      axis.ticks.push_back({std::clamp(at, 0.0, 1.0), label});
    }
  }
}

}  // namespace

bool PlotAxis::can_show(double value) const { return std::isfinite(value) && (!log || value > 0); }
double PlotAxis::position_of(double value) const { return ((log ? std::log10(value) : value) - low) / (high - low); }

PlotAxis make_axis(const std::vector<double>& values, bool log, int labels) {
  PlotAxis axis;
  axis.log = log;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values) {
    if (!axis.can_show(value)) continue;
    const double v = log ? std::log10(value) : value;
    low = std::min(low, v), high = std::max(high, v);
  }
  if (!(low <= high)) low = log ? -1 : 0, high = log ? 0 : 1;
  // A smaller range counts as a single value and gets a wide margin, since the differences may be rounding errors.
  const double min_range = log ? 0.1 : std::max(1e-9 * std::max(std::abs(low), std::abs(high)), 1e-300);
  if (high - low < min_range) {
    const double around = log ? 0.5 : std::max(std::abs(low) * 0.5, 0.5);
    low -= around, high += around;
  }
  const double margin = 0.03 * (high - low);
  // A linear axis whose smallest value is 0 starts exactly at 0.
  axis.low = !log && low == 0 ? 0 : low - margin;
  axis.high = high + margin;
  if (log)
    make_log_ticks(axis, labels);
  else
    make_round_ticks(axis, axis.low, axis.high, labels);
  return axis;
}

}  // namespace simplexseg
