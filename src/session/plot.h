// SPDX-License-Identifier: Apache-2.0
// What a plot shows; io/plot_io.h draws it.
#pragma once
#include <string>
#include <vector>

#include "core/colour.h"

namespace simplexseg {

struct PlotSeries {
  std::string name;  ///< in the legend; empty: not there
  Colour colour{0, 114, 178};
  bool markers = false;  ///< at each value, in a shape that differs from series to series
  bool dashed = false;
  std::vector<double> x, y;  ///< as many of each; a line ends where a value is not finite, or not > 0 on a log axis
};

struct Plot {
  std::string title, x_title, y_title;
  bool log_x = false, log_y = false;
  std::vector<PlotSeries> series;
};

enum class PlotTheme { Light, Dark };

/// Colours that people who do not see red and green alike still tell apart, on a light and on a dark ground (after
/// Okabe and Ito 2008, Color Universal Design); they repeat after the eighth.
inline Colour plot_colour(std::size_t series) {
  constexpr Colour colours[] = {{0, 114, 178}, {213, 94, 0},   {0, 158, 115},   {204, 121, 167},
                                {230, 159, 0}, {86, 180, 233}, {136, 106, 226}, {128, 128, 128}};
  return colours[series % (sizeof colours / sizeof *colours)];
}

}  // namespace simplexseg
