// SPDX-License-Identifier: Apache-2.0
// Contents of a plot; io/picture/plot_io.h draws it.
#pragma once
#include <string>
#include <vector>

#include "core/colour.h"

namespace simplexseg {

struct PlotSeries {
  std::string name;  ///< name in the legend; empty: not listed
  Colour colour{0, 114, 178};
  bool markers = false;  ///< whether each value has a marker, whose shape differs between series
  bool dashed = false;
  std::vector<double> x, y;  ///< same size; values that are not finite, or not above 0 on a log axis, leave gaps
};

struct Plot {
  std::string title, x_title, y_title;
  bool log_x = false, log_y = false;
  std::vector<PlotSeries> series;
};

enum class PlotTheme { Light, Dark };

/// Colour of a series, one of eight that people with red-green colour blindness can distinguish on light and on dark
/// backgrounds (after Okabe and Ito 2008, Color Universal Design). `series`: index of the series; the colours repeat
/// after eight.
inline Colour plot_colour(std::size_t series) {
  constexpr Colour colours[] = {{0, 114, 178}, {213, 94, 0},   {0, 158, 115},   {204, 121, 167},
                                {230, 159, 0}, {86, 180, 233}, {136, 106, 226}, {128, 128, 128}};
  return colours[series % (sizeof colours / sizeof *colours)];
}

}  // namespace simplexseg
