// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "session/plot.h"

namespace simplexseg {

/// Draws a plot of `width` x `height` pixels as opaque RGBA, 8 bits per channel, rows from the top. `scale`: factor for
/// the size of text and lines. Throws Error for a size outside 1..16384 or a series whose x and y differ in length.
std::vector<std::uint8_t> draw_plot(const Plot& plot, int width, int height, double scale, PlotTheme theme);

/// Throws Error if write_plot() does not support the extension of `path`.
void require_plot_name(const std::filesystem::path& path);
/// Writes .svg or .png in the light theme through a temporary file; width and height in pixels. The description of an
/// SVG contains the title and the names of the series, because its letters are drawn as outlines. Throws the errors of
/// draw_plot(), and Error for another extension, a missing folder or a failed write.
void write_plot(const std::filesystem::path& path, const Plot& plot, int width, int height);

}  // namespace simplexseg
