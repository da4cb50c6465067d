// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "session/plot.h"

namespace simplexseg {

/// The plot as RGBA, 8 bits each, rows from the top, opaque: `width` x `height` pixels, text and lines `scale` times as
/// large as at 1. Throws Error for a size outside 1..16384 or a series whose x and y differ in length.
std::vector<std::uint8_t> draw_plot(const Plot& plot, int width, int height, double scale, PlotTheme theme);

/// Throws Error when write_plot() does not know the extension of `path`.
void require_plot_name(const std::filesystem::path& path);
/// Writes .svg or .png, light, whole or not at all; from the same drawing code. An SVG names title and series in its
/// description, for its letters are outlines. Throws Error for another extension, a folder that does not exist, a
/// failed write, and as draw_plot().
void write_plot(const std::filesystem::path& path, const Plot& plot, int width, int height);

}  // namespace simplexseg
