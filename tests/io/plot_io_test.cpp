// SPDX-License-Identifier: Apache-2.0
// Plot files can be parsed and contain the names; different data give different pixels.
#include "io/picture/plot_io.h"

#include <cmath>
#include <limits>

#include "io/picture/plot_axis.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::bytes_of;
using test::error_of;
using PlotFile = test::FolderTest;

Plot two_curves() {
  Plot plot{"Error & time <held>", "time (s)", "error", true, true, {}};
  PlotSeries fast{"fast, \"quoted\"", plot_colour(0), true, false, {}, {}},
      slow{"slow <&>", plot_colour(1), false, true, {}, {}};
  for (int i = 1; i <= 50; ++i) {
    fast.x.push_back(0.01 * i), fast.y.push_back(std::exp(-0.3 * i));
    slow.x.push_back(0.02 * i), slow.y.push_back(std::exp(-0.05 * i));
  }
  plot.series = {fast, slow};
  return plot;
}

std::uint32_t u32(const std::string& bytes, std::size_t at) {
  return std::uint32_t(std::uint8_t(bytes[at])) << 24 | std::uint32_t(std::uint8_t(bytes[at + 1])) << 16 |
         std::uint32_t(std::uint8_t(bytes[at + 2])) << 8 | std::uint8_t(bytes[at + 3]);
}

/// Whether all tags are closed in order and the text has no unescaped '<' or '&'.
bool well_formed(const std::string& xml) {
  std::vector<std::string> open;
  for (std::size_t at = 0; at < xml.size(); ++at) {
    if (xml[at] == '&') {
      const std::size_t end = xml.find(';', at);
      if (end == std::string::npos || end - at > 8) return false;
    }
    if (xml[at] != '<') continue;
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return false;
    const std::string tag = xml.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string::npos) return false;
    const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" \n/", 1) - (tag[0] == '/'));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != name) return false;
      open.pop_back();
    } else if (tag[0] != '?' && tag[0] != '!' && tag.back() != '/') {
      open.push_back(name);
    }
    at = end;
  }
  return open.empty();
}

TEST_F(PlotFile, SvgIsWellFormedAndNamesItsSeries) {
  write_plot(folder / "a.svg", two_curves(), 700, 400);
  const std::string svg = bytes_of(folder / "a.svg");
  EXPECT_TRUE(well_formed(svg)) << svg.substr(0, 1000);
  EXPECT_FALSE(well_formed("<a><b></a></b>"));
  for (const char* words :
       {"Error &amp; time &lt;held&gt;", "fast, \"quoted\"", "slow &lt;&amp;&gt;", "error against time (s)"})
    EXPECT_HAS(svg, words);
  EXPECT_HAS(svg, "width=\"700");
}

TEST_F(PlotFile, PngHasTheSizeAndChangesWithTheData) {
  Plot plot = two_curves();
  write_plot(folder / "a.png", plot, 640, 360);
  const std::string png = bytes_of(folder / "a.png");
  ASSERT_EQ(png.substr(1, 3), "PNG");
  EXPECT_EQ(u32(png, 16), 640u);
  EXPECT_EQ(u32(png, 20), 360u);
  EXPECT_EQ(png.substr(png.size() - 8, 4), "IEND");
  write_plot(folder / "same.png", plot, 640, 360);
  EXPECT_EQ(bytes_of(folder / "same.png"), png);
  for (double& y : plot.series[0].y) y *= 2;
  write_plot(folder / "b.png", plot, 640, 360);
  EXPECT_NE(bytes_of(folder / "b.png"), png);
}

/// Number of pixels similar to a colour, in columns from `from`.
int pixels_like(const std::vector<std::uint8_t>& rgba, int width, const Colour& colour, int from = 0) {
  int count = 0;
  for (std::size_t p = 0; p < rgba.size() / 4; ++p)
    if (static_cast<int>(p) % width >= from)
      count += std::abs(rgba[4 * p] - colour.red) + std::abs(rgba[4 * p + 1] - colour.green) +
                   std::abs(rgba[4 * p + 2] - colour.blue) <
               40;
  return count;
}

TEST(Plot, CurvesAreDrawnInTheirColoursBesideTheLegend) {
  const Plot plot = two_curves();
  for (const PlotTheme theme : {PlotTheme::Light, PlotTheme::Dark}) {
    const auto rgba = draw_plot(plot, 640, 360, 1, theme);
    ASSERT_EQ(rgba.size(), 4u * 640 * 360);
    for (std::size_t p = 3; p < rgba.size(); p += 4) ASSERT_EQ(rgba[p], 255);
    for (const PlotSeries& s : plot.series) {
      EXPECT_GT(pixels_like(rgba, 640, s.colour), 150);
      // The line in the legend, to the right of the data.
      EXPECT_GT(pixels_like(rgba, 640, s.colour, 480), 10);
    }
    Plot without = plot;
    without.series[0].x.clear(), without.series[0].y.clear();
    EXPECT_LT(pixels_like(draw_plot(without, 640, 360, 1, theme), 640, plot.series[0].colour),
              pixels_like(rgba, 640, plot.series[0].colour) / 2);
  }
  EXPECT_GT(draw_plot(plot, 640, 360, 1, PlotTheme::Light)[0], 200);
  EXPECT_LT(draw_plot(plot, 640, 360, 1, PlotTheme::Dark)[0], 60);
  // Twice the scale on twice the pixels: lines are twice as long and twice as wide.
  const int once = pixels_like(draw_plot(plot, 640, 360, 1, PlotTheme::Light), 640, plot.series[0].colour);
  const int twice = pixels_like(draw_plot(plot, 1280, 720, 2, PlotTheme::Light), 1280, plot.series[0].colour);
  EXPECT_NEAR(twice, 4.0 * once, 1.5 * once);
}

TEST(Plot, ASeriesWithoutANameIsNotInTheLegend) {
  const Plot plot = two_curves();
  Plot unnamed = plot;
  for (PlotSeries& s : unnamed.series) s.name.clear();
  const auto rgba = draw_plot(unnamed, 640, 360, 1, PlotTheme::Light);
  // Without a legend the curves extend into its space.
  EXPECT_GT(pixels_like(rgba, 640, plot.series[1].colour, 560), 0);
  EXPECT_EQ(pixels_like(draw_plot(plot, 640, 360, 1, PlotTheme::Light), 640, plot.series[1].colour, 560), 0);
}

TEST(Plot, UnusualDataAndSizesAreDrawn) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Plot plot{"", "", "", true, true, {}};
  EXPECT_EQ(draw_plot(plot, 300, 200, 1, PlotTheme::Light).size(), 4u * 300 * 200);
  PlotSeries odd{"odd", plot_colour(2), true, false, {nan, -1, 0, 1, inf, 2}, {1, 1, 1, 1e-300, 1, 1e300}};
  plot.series = {odd, odd};
  for (const auto& [width, height] : {std::pair{1, 1}, {30, 400}, {400, 30}, {2000, 100}}) {
    EXPECT_EQ(draw_plot(plot, width, height, 1, PlotTheme::Dark).size(), 4u * width * height);
    plot.log_x = !plot.log_x, plot.log_y = !plot.log_y;
  }
  for (int n = 0; n < 100; ++n) plot.series.push_back(odd);
  EXPECT_NO_THROW(draw_plot(plot, 300, 200, 1, PlotTheme::Light));
}

TEST_F(PlotFile, InvalidInputIsRejected) {
  Plot plot = two_curves();
  EXPECT_HAS(error_of([&] { write_plot(folder / "a.jpg", plot, 100, 100); }), ".svg or .png");
  EXPECT_HAS(error_of([&] { write_plot(folder / "none" / "a.png", plot, 100, 100); }), "none");
  EXPECT_HAS(error_of([&] { write_plot(folder / "a.png", plot, 0, 100); }), "out of range");
  EXPECT_HAS(error_of([&] { draw_plot(plot, 100, 100000, 1, PlotTheme::Light); }), "out of range");
  EXPECT_HAS(error_of([&] { draw_plot(plot, 100, 100, 0, PlotTheme::Light); }), "scale");
  plot.series[1].y.pop_back();
  EXPECT_HAS(error_of([&] { write_plot(folder / "a.svg", plot, 100, 100); }), "slow");
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

std::vector<std::string> labels_of(const PlotAxis& axis) {
  std::vector<std::string> labels;
  for (const PlotAxis::Tick& tick : axis.ticks)
    if (!tick.label.empty()) labels.push_back(tick.label);
  return labels;
}

TEST(PlotAxis, LogAxesHaveDecadesAndTheirParts) {
  const PlotAxis axis = make_axis({0.01, 5, -3, 0}, true, 8);
  EXPECT_EQ(labels_of(axis), (std::vector<std::string>{"0.01", "0.1", "1"}));
  EXPECT_GT(axis.ticks.size(), 20u);
  EXPECT_NEAR(axis.position_of(10) - axis.position_of(1), axis.position_of(1) - axis.position_of(0.1), 1e-12);
  EXPECT_FALSE(axis.can_show(0));
  EXPECT_EQ(labels_of(make_axis({1e-8, 1e-4}, true, 8)).back(), "10⁻⁴");
  EXPECT_LE(labels_of(make_axis({1e-300, 1e300}, true, 6)).size(), 7u);
  EXPECT_GE(labels_of(make_axis({2.1, 3.9}, true, 6)).size(), 2u);
}

TEST(PlotAxis, LinearAxesHaveRoundNumbers) {
  EXPECT_EQ(labels_of(make_axis({0, 10}, false, 5)), (std::vector<std::string>{"0", "5", "10"}));
  EXPECT_EQ(labels_of(make_axis({0.1, 0.3}, false, 4)), (std::vector<std::string>{"0.1", "0.2", "0.3"}));
  EXPECT_EQ(labels_of(make_axis({-2, 2}, false, 4)), (std::vector<std::string>{"-2", "0", "2"}));
  EXPECT_GE(labels_of(make_axis({7, 7}, false, 4)).size(), 1u);
  EXPECT_GE(labels_of(make_axis({}, false, 4)).size(), 2u);
}

}  // namespace
}  // namespace simplexseg
