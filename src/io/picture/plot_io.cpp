// SPDX-License-Identifier: Apache-2.0
#include "io/picture/plot_io.h"

#include <cairo-svg.h>
#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "core/error.h"
#include "core/number_text.h"
#include "io/picture/cairo_drawing.h"
#include "io/picture/plot_axis.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr double kTextPixels = 13, kTitlePixels = 16, kSmallestText = 7;
constexpr int kMaxPixels = 16384;

/// Colours of a theme: background of the picture, background of the axes, text and lines, major and minor grid.
struct Palette {
  Colour paper, plot, ink, grid, minor;
};
Palette palette_of(PlotTheme theme) {
  if (theme == PlotTheme::Dark) return {{32, 33, 36}, {24, 25, 28}, {225, 225, 228}, {72, 74, 80}, {46, 48, 52}};
  return {{255, 255, 255}, {255, 255, 255}, {30, 30, 34}, {200, 202, 206}, {234, 235, 238}};
}

/// Draws one plot; lengths are in pixels at scale 1.
class Drawing {
 public:
  Drawing(cairo_t* cairo, const Plot& plot, double width, double height, PlotTheme theme)
      : c_(cairo), plot_(plot), width_(width), height_(height), palette_(palette_of(theme)) {}

  void draw() {
    cairo_select_font_face(c_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    set(palette_.paper);
    cairo_paint(c_);
    lay_out();
    draw_grid();
    draw_series();
    draw_frame();
    draw_legend();
  }

 private:
  void set(const Colour& colour) {
    cairo_set_source_rgb(c_, colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
  }
  double text_width(const std::string& text, double size) { return simplexseg::text_width(c_, text, size); }
  /// Draws text with its baseline at y. `across`: part of the text at x, 0 its left end, 0.5 its middle, 1 its right
  /// end.
  void text(const std::string& words, double x, double y, double size, double across = 0) {
    const double width = text_width(words, size);
    cairo_move_to(c_, x - across * width, y);
    cairo_show_text(c_, words.c_str());
  }
  void lay_out() {
    std::vector<double> x, y;
    for (const PlotSeries& s : plot_.series)
      for (std::size_t i = 0; i < s.x.size(); ++i) {
        // A point that one axis cannot show does not extend the range of the other axis.
        const bool shown = std::isfinite(s.x[i]) && std::isfinite(s.y[i]) && (!plot_.log_x || s.x[i] > 0) &&
                           (!plot_.log_y || s.y[i] > 0);
        if (shown) x.push_back(s.x[i]), y.push_back(s.y[i]);
      }
    is_empty_ = x.empty();
    top_ = plot_.title.empty() ? 12 : 14 + kTitlePixels + 10;
    bottom_ = height_ - 12 - (plot_.x_title.empty() ? 0 : kTextPixels + 8) - kTextPixels - 8;
    y_ = make_axis(y, plot_.log_y, std::max(2, static_cast<int>((bottom_ - top_) / 45)));
    double widest = 0;
    for (const PlotAxis::Tick& tick : y_.ticks) widest = std::max(widest, text_width(tick.label, kTextPixels));
    left_ = 10 + (plot_.y_title.empty() ? 0 : kTextPixels + 10) + widest + 8;
    // The legend is to the right of the axes and takes less than half of the width.
    legend_size_ = kTextPixels;
    const double legend_height = bottom_ - top_;
    const auto rows = static_cast<double>(named_series());
    if (rows > 1) legend_size_ = std::clamp(legend_height / (rows * 1.45), kSmallestText, kTextPixels);
    double legend = 0;
    if (has_legend()) {
      for (const PlotSeries& s : plot_.series) legend = std::max(legend, text_width(s.name, legend_size_));
      legend = std::min(legend, 0.42 * width_ - 52) + 52;
    }
    right_ = width_ - 16 - std::max(legend, 0.0);
    right_ = std::max(right_, left_ + 20), bottom_ = std::max(bottom_, top_ + 20);
    x_ = make_axis(x, plot_.log_x, std::max(2, static_cast<int>((right_ - left_) / 75)));
  }
  /// Whether there are several named series; a legend with one entry would repeat the title.
  bool has_legend() const { return named_series() > 1; }
  std::size_t named_series() const {
    return static_cast<std::size_t>(
        std::count_if(plot_.series.begin(), plot_.series.end(), [](const PlotSeries& s) { return !s.name.empty(); }));
  }

  double at_x(double position) const { return left_ + position * (right_ - left_); }
  double at_y(double position) const { return bottom_ - position * (bottom_ - top_); }

  void line(double x0, double y0, double x1, double y1) {
    cairo_move_to(c_, x0, y0);
    cairo_line_to(c_, x1, y1);
    cairo_stroke(c_);
  }

  void draw_grid() {
    set(palette_.plot);
    cairo_rectangle(c_, left_, top_, right_ - left_, bottom_ - top_);
    cairo_fill(c_);
    cairo_set_line_width(c_, 1);
    for (const bool labelled : {false, true}) {
      set(labelled ? palette_.grid : palette_.minor);
      for (const PlotAxis::Tick& tick : x_.ticks)
        if (tick.label.empty() != labelled) line(at_x(tick.position), top_, at_x(tick.position), bottom_);
      for (const PlotAxis::Tick& tick : y_.ticks)
        if (tick.label.empty() != labelled) line(left_, at_y(tick.position), right_, at_y(tick.position));
    }
  }

  void draw_frame() {
    set(palette_.ink);
    cairo_set_line_width(c_, 1);
    cairo_rectangle(c_, left_, top_, right_ - left_, bottom_ - top_);
    cairo_stroke(c_);
    double free_from = -1e9;
    for (const PlotAxis::Tick& tick : x_.ticks) {
      const double x = at_x(tick.position);
      line(x, bottom_, x, bottom_ + (tick.label.empty() ? 3 : 6));
      const double half = text_width(tick.label, kTextPixels) / 2;
      if (tick.label.empty() || x - half < free_from) continue;
      text(tick.label, x, bottom_ + 8 + kTextPixels, kTextPixels, 0.5);
      free_from = x + half + 6;
    }
    for (const PlotAxis::Tick& tick : y_.ticks) {
      const double y = at_y(tick.position);
      line(left_ - (tick.label.empty() ? 3 : 6), y, left_, y);
      text(tick.label, left_ - 8, y + 0.36 * kTextPixels, kTextPixels, 1);
    }
    if (!plot_.title.empty()) {
      const std::string title = fitted_text(c_, plot_.title, kTitlePixels, width_ - left_ - 16);
      text(title, left_, 12 + kTitlePixels, kTitlePixels);
    }
    if (!plot_.x_title.empty())
      text(fitted_text(c_, plot_.x_title, kTextPixels, width_ - 16), (left_ + right_) / 2, height_ - 12, kTextPixels,
           0.5);
    if (!plot_.y_title.empty()) {
      const std::string title = fitted_text(c_, plot_.y_title, kTextPixels, height_ - 8);
      const double half = text_width(title, kTextPixels) / 2 + 4;  // centred on the axis, but within the picture
      cairo_save(c_);
      cairo_translate(c_, 8 + kTextPixels, std::max(half, std::min((top_ + bottom_) / 2, height_ - half)));
      cairo_rotate(c_, -M_PI / 2);
      text(title, 0, 0, kTextPixels, 0.5);
      cairo_restore(c_);
    }
    if (is_empty_) {
      text("no data", (left_ + right_) / 2, (top_ + bottom_) / 2, kTitlePixels, 0.5);
    }
  }

  void draw_series() {
    cairo_save(c_);
    cairo_rectangle(c_, left_ - 6, top_ - 6, right_ - left_ + 12, bottom_ - top_ + 12);
    cairo_clip(c_);
    cairo_set_line_join(c_, CAIRO_LINE_JOIN_ROUND);
    for (std::size_t n = 0; n < plot_.series.size(); ++n) {
      const PlotSeries& s = plot_.series[n];
      begin_stroke(s);
      bool drawing = false;
      double last_x = 0;
      double last_y = 0;
      for (std::size_t i = 0; i < s.x.size(); ++i) {
        if (!x_.can_show(s.x[i]) || !y_.can_show(s.y[i])) {
          drawing = false;
          continue;
        }
        const double x = at_x(x_.position_of(s.x[i])), y = at_y(y_.position_of(s.y[i]));
        // Points within 0.2 pixels of the previous one are skipped, to limit the length of the path.
        if (drawing && std::abs(x - last_x) < 0.2 && std::abs(y - last_y) < 0.2) continue;
        drawing ? cairo_line_to(c_, x, y) : cairo_move_to(c_, x, y);
        drawing = true, last_x = x, last_y = y;
      }
      cairo_stroke(c_);
      cairo_set_dash(c_, nullptr, 0, 0);
      if (!s.markers) continue;
      double marked_x = -1e9, marked_y = -1e9;
      for (std::size_t i = 0; i < s.x.size(); ++i) {
        if (!x_.can_show(s.x[i]) || !y_.can_show(s.y[i])) continue;
        const double x = at_x(x_.position_of(s.x[i])), y = at_y(y_.position_of(s.y[i]));
        if (std::hypot(x - marked_x, y - marked_y) < 14 && i + 1 < s.x.size()) continue;
        marker(x, y, n);
        marked_x = x, marked_y = y;
      }
    }
    cairo_restore(c_);
  }

  void begin_stroke(const PlotSeries& s) {
    set(s.colour);
    cairo_set_line_width(c_, 1.8);
    const double dashes[] = {6, 4};
    cairo_set_dash(c_, dashes, s.dashed ? 2 : 0, 0);
    cairo_new_path(c_);
  }

  /// Draws a marker, filled with the colour of the series and outlined with the background.
  void marker(double x, double y, std::size_t series) {
    constexpr double r = 4;
    cairo_new_path(c_);
    const auto corners = [&](int count, double turn) {
      for (int k = 0; k < count; ++k)
        cairo_line_to(c_, x + 1.15 * r * std::sin(turn + 2 * M_PI * k / count),
                      y - 1.15 * r * std::cos(turn + 2 * M_PI * k / count));
    };
    switch (series % 6) {
      case 0:
        cairo_arc(c_, x, y, 0.9 * r, 0, 2 * M_PI);
        break;
      case 1:
        corners(4, M_PI / 4);
        break;
      case 2:
        corners(3, 0);
        break;
      case 3:
        corners(4, 0);
        break;
      case 4:
        corners(3, M_PI);
        break;
      default:
        corners(5, 0);
        break;
    }
    cairo_close_path(c_);
    set(plot_.series[series].colour);
    cairo_fill_preserve(c_);
    set(palette_.plot);
    cairo_set_line_width(c_, 0.7);
    cairo_stroke(c_);
  }

  void draw_legend() {
    if (!has_legend()) return;
    const double row = legend_size_ * 1.45, room = bottom_ - top_ + 8;
    const auto fit = std::max<std::size_t>(1, static_cast<std::size_t>(room / row));
    const double x = right_ + 12;
    const std::size_t entries = named_series();
    std::size_t entry = 0;
    for (std::size_t n = 0; n < plot_.series.size(); ++n) {
      if (plot_.series[n].name.empty()) continue;
      const double y = top_ + (static_cast<double>(entry++) + 0.5) * row;
      if (entries > fit && entry == fit) {
        set(palette_.ink);
        text("and " + std::to_string(entries - entry + 1) + " more", x + 34, y + 0.36 * legend_size_, legend_size_);
        return;
      }
      begin_stroke(plot_.series[n]);
      line(x, y, x + 28, y);
      cairo_set_dash(c_, nullptr, 0, 0);
      if (plot_.series[n].markers) marker(x + 14, y, n);
      set(palette_.ink);
      text(fitted_text(c_, plot_.series[n].name, legend_size_, width_ - x - 34 - 4), x + 34, y + 0.36 * legend_size_,
           legend_size_);
    }
  }

  cairo_t* const c_;
  const Plot& plot_;
  const double width_, height_;
  const Palette palette_;
  PlotAxis x_, y_;
  double left_ = 0, right_ = 0, top_ = 0, bottom_ = 0, legend_size_ = kTextPixels;
  bool is_empty_ = false;
};

void check(const Plot& plot, int width, int height) {
  if (width < 1 || height < 1 || width > kMaxPixels || height > kMaxPixels)
    throw Error("cannot draw a plot of " + std::to_string(width) + " x " + std::to_string(height) + " pixels",
                "the size is out of range", "choose 1 to " + std::to_string(kMaxPixels));
  for (const PlotSeries& s : plot.series)
    if (s.x.size() != s.y.size())
      throw Error("cannot plot the series '" + s.name + "'", "it has different numbers of x and y values",
                  "use one y for each x");
}

void draw_on(cairo_surface_t* surface, const Plot& plot, int width, int height, double scale, PlotTheme theme) {
  const CairoContext cairo(cairo_create(surface));
  cairo_scale(cairo.get(), scale, scale);
  Drawing(cairo.get(), plot, width / scale, height / scale, theme).draw();
  cairo_surface_flush(surface);
  if (const cairo_status_t status = cairo_status(cairo.get()); status != CAIRO_STATUS_SUCCESS)
    throw Error("cannot draw the plot", cairo_status_to_string(status), "make it smaller");
}

CairoSurface image_of(const Plot& plot, int width, int height, double scale, PlotTheme theme) {
  CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
  draw_on(surface.get(), plot, width, height, scale, theme);
  return surface;
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

std::string xml_text(const std::string& words) {
  std::string text;
  for (const char c : words) {
    if (c == '&')
      text += "&amp;";
    else if (c == '<')
      text += "&lt;";
    else if (c == '>')
      text += "&gt;";
    else
      text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return text;
}

std::string svg_bytes(const Plot& plot, int width, int height) {
  std::string bytes;
  {
    const CairoSurface surface(cairo_svg_surface_create_for_stream(append, &bytes, width, height));
    draw_on(surface.get(), plot, width, height, 1, PlotTheme::Light);
    cairo_surface_finish(surface.get());
  }
  std::string words = "\n<title>" + xml_text(plot.title) + "</title>\n<desc>" +
                      xml_text(plot.y_title + " against " + plot.x_title) + ":";
  for (const PlotSeries& s : plot.series)
    if (!s.name.empty()) words.append(" ").append(xml_text(s.name)).append(";");
  words.back() = '.';
  words += "</desc>\n";
  const std::size_t root = bytes.find("<svg"), inside = bytes.find('>', root);
  if (root == std::string::npos || inside == std::string::npos)
    throw Error("cannot write the plot", "its SVG has no root element", "write a PNG instead");
  bytes.insert(inside + 1, words);
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> draw_plot(const Plot& plot, int width, int height, double scale, PlotTheme theme) {
  check(plot, width, height);
  if (!(scale > 0.01 && scale < 100))
    throw Error("cannot draw the plot", "the scale " + general_text(scale, 6) + " is out of range",
                "choose 0.01 to 100");
  const CairoSurface surface = image_of(plot, width, height, scale, theme);
  const unsigned char* pixels = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  std::vector<std::uint8_t> rgba;
  rgba.reserve(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(pixels + static_cast<std::ptrdiff_t>(y) * stride);
    for (int x = 0; x < width; ++x)
      for (const int shift : {16, 8, 0, -1})
        rgba.push_back(shift < 0 ? 255 : static_cast<std::uint8_t>(row[x] >> shift & 0xff));
  }
  return rgba;
}

void require_plot_name(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  if (extension != ".svg" && extension != ".png")
    throw Error("cannot write " + quoted(path), "the extension '" + one_line(extension) + "' is not supported",
                "use .svg or .png");
}

void write_plot(const std::filesystem::path& path, const Plot& plot, int width, int height) {
  require_plot_name(path);
  check(plot, width, height);
  AtomicFile file(path);
  std::string bytes;
  if (extension_of(path) == ".svg") {
    bytes = svg_bytes(plot, width, height);
  } else {
    const CairoSurface surface = image_of(plot, width, height, 1, PlotTheme::Light);
    if (cairo_surface_write_to_png_stream(surface.get(), append, &bytes) != CAIRO_STATUS_SUCCESS)
      throw file.failed("the PNG cannot be encoded", "write an SVG instead");
  }
  write_bytes(file, bytes);
  file.commit();
}

}  // namespace simplexseg
