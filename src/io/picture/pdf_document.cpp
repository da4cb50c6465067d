// SPDX-License-Identifier: Apache-2.0
#include "io/picture/pdf_document.h"

#include <cairo-pdf.h>
#include <cairo.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "core/error.h"
#include "io/picture/cairo_drawing.h"

namespace simplexseg {
namespace {

// Lengths in points (1/72 inch): A4, its margins, and the sizes of fonts.
constexpr double kWidth = 595.28, kHeight = 841.89, kMargin = 48, kFoot = 36;
constexpr double kLeft = kMargin, kRight = kWidth - kMargin, kBottom = kHeight - kMargin - kFoot / 2;
constexpr double kTitle = 18, kHeading = 12.5, kText = 9.5, kSmall = 8;
constexpr double kLine = 1.4;  ///< distance of lines, in sizes of the font
constexpr double kCellGap = 10, kMaxPictureHeight = 260;

cairo_status_t append_bytes(void* bytes, const unsigned char* data, unsigned count) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), count);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

/// Place on the page at which the next block begins.
class PdfDocument::Page {
 public:
  explicit Page(std::string footer)
      : surface_(cairo_pdf_surface_create_for_stream(append_bytes, &bytes_, kWidth, kHeight)),
        cairo_(cairo_create(surface_.get())),
        footer_(std::move(footer)) {}

  cairo_t* cairo() const { return cairo_.get(); }
  cairo_surface_t* surface() const { return surface_.get(); }
  double y = kMargin;

  /// Begins the next page unless a block of this height fits on this one.
  void need(double height) {
    if (y + height <= kBottom || y == kMargin) return;
    end_page();
    y = kMargin;
  }
  void set_font(bool bold) const {
    cairo_select_font_face(cairo(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  }
  /// Writes one line with its baseline at `baseline`. `across`: part of the text at x, 0 its left end, 1 its right end.
  void write(const std::string& text, double x, double baseline, double size, double across = 0) const {
    cairo_move_to(cairo(), x - across * text_width(cairo(), text, size), baseline);
    cairo_show_text(cairo(), text.c_str());
  }
  /// Breaks a text into lines of a width, between words where possible.
  std::vector<std::string> lines_of(const std::string& text, double size, double width) const {
    std::vector<std::string> lines;
    std::istringstream words(text);
    std::string line, word;
    const auto fits = [&](const std::string& one) { return text_width(cairo(), one, size) <= width; };
    while (words >> word) {
      std::string longer = line;
      if (!line.empty()) longer += ' ';
      longer += word;
      if (fits(longer)) {
        line = longer;
        continue;
      }
      if (!line.empty()) lines.push_back(line);
      for (line = word; !fits(line);) {  // a word that is too long is broken between characters
        std::size_t end = line.size();
        while (end > 1 && (!fits(line.substr(0, end)) || (line[end] & 0xc0) == 0x80)) --end;
        if (end == line.size()) break;
        lines.push_back(line.substr(0, end));
        line.erase(0, end);
      }
    }
    if (!line.empty()) lines.push_back(line);
    return lines;
  }
  void rule(double at, double grey) const {
    cairo_set_source_rgb(cairo(), grey, grey, grey);
    cairo_set_line_width(cairo(), 0.5);
    cairo_move_to(cairo(), kLeft, at);
    cairo_line_to(cairo(), kRight, at);
    cairo_stroke(cairo());
    cairo_set_source_rgb(cairo(), 0, 0, 0);
  }
  std::string finish() {
    end_page();
    cairo_surface_finish(surface());
    for (const cairo_status_t status : {cairo_status(cairo()), cairo_surface_status(surface())})
      if (status != CAIRO_STATUS_SUCCESS)
        throw Error("cannot write the report", std::string("cairo reports: ") + cairo_status_to_string(status),
                    "check the names in it");
    return std::move(bytes_);
  }

 private:
  void end_page() {
    set_font(false);
    rule(kHeight - kMargin - 12, 0.7);
    write(fitted_text(cairo(), footer_, kSmall, kRight - kLeft - 60), kLeft, kHeight - kMargin, kSmall);
    write("page " + std::to_string(++pages_), kRight, kHeight - kMargin, kSmall, 1);
    cairo_show_page(cairo());
  }

  std::string bytes_;  // outlives the surface, which writes into it
  CairoSurface surface_;
  CairoContext cairo_;
  std::string footer_;
  int pages_ = 0;
};

PdfDocument::PdfDocument(const std::string& title, std::string footer)
    : page_(std::make_unique<Page>(std::move(footer))) {
  cairo_pdf_surface_set_metadata(page_->surface(), CAIRO_PDF_METADATA_TITLE, title.c_str());
  cairo_pdf_surface_set_metadata(page_->surface(), CAIRO_PDF_METADATA_CREATOR, "SimplexSeg " SIMPLEXSEG_VERSION);
  page_->set_font(true);
  page_->y += kTitle;
  page_->write(fitted_text(page_->cairo(), title, kTitle, kRight - kLeft), kLeft, page_->y, kTitle);
  page_->y += 0.6 * kTitle;
}

PdfDocument::~PdfDocument() = default;

void PdfDocument::add_heading(const std::string& text) {
  page_->need(kHeading * 2 + 5 * kText * kLine);  // not alone at the foot of a page
  page_->set_font(true);
  page_->y += kHeading * 1.9;
  page_->write(fitted_text(page_->cairo(), text, kHeading, kRight - kLeft), kLeft, page_->y, kHeading);
  page_->y += 0.55 * kHeading;
}

void PdfDocument::add_paragraph(const std::string& text, bool emphasised) {
  page_->set_font(emphasised);
  for (const std::string& line : page_->lines_of(text, kText, kRight - kLeft)) {
    page_->need(kText * kLine);
    page_->set_font(emphasised);
    page_->y += kText * kLine;
    page_->write(line, kLeft, page_->y, kText);
  }
  page_->y += 0.3 * kText;
}

void PdfDocument::add_facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  page_->set_font(false);
  double names = 0;
  for (const auto& [name, value] : facts) names = std::max(names, text_width(page_->cairo(), name, kText));
  const double at = kLeft + names + kCellGap * 1.5;
  for (const auto& [name, value] : facts) {
    bool first = true;
    for (const std::string& line : page_->lines_of(value, kText, kRight - at)) {
      page_->need(kText * kLine);
      page_->set_font(false);
      page_->y += kText * kLine;
      if (first) {
        cairo_set_source_rgb(page_->cairo(), 0.35, 0.35, 0.35);
        page_->write(name, kLeft, page_->y, kText);
        cairo_set_source_rgb(page_->cairo(), 0, 0, 0);
      }
      page_->write(line, at, page_->y, kText);
      first = false;
    }
  }
  page_->y += 0.3 * kText;
}

void PdfDocument::add_table(const std::vector<std::vector<std::string>>& rows, std::size_t first_right) {
  if (rows.empty()) return;
  const std::size_t columns = rows.front().size();
  page_->set_font(true);  // widths of bold text hold for all rows
  std::vector<double> widths(columns, 0);
  for (const std::vector<std::string>& row : rows)
    for (std::size_t c = 0; c < columns; ++c)
      widths[c] = std::max(widths[c], text_width(page_->cairo(), row[c], kText) + kCellGap);
  double total = 0;
  for (const double width : widths) total += width;
  const double room = kRight - kLeft;
  if (total > room) {  // the widest column gives way
    double& widest = *std::max_element(widths.begin(), widths.end());
    widest = std::max(widest - (total - room), 60.0);
  }
  const auto draw = [&](const std::vector<std::string>& row, bool bold) {
    page_->set_font(bold);
    page_->y += kText * 1.5;
    double x = kLeft;
    for (std::size_t c = 0; c < columns; ++c) {
      const std::string cell = fitted_text(page_->cairo(), row[c], kText, widths[c] - kCellGap + 0.01);
      const bool right = c >= first_right;
      page_->write(cell, right ? x + widths[c] - kCellGap : x, page_->y, kText, right ? 1 : 0);
      x += widths[c];
    }
  };
  const auto draw_head = [&] {
    draw(rows.front(), true);
    page_->rule(page_->y + 0.4 * kText, 0.4);
    page_->y += 0.3 * kText;
  };
  page_->need(3.5 * kText * 1.5);
  draw_head();
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const double before = page_->y;
    page_->need(kText * 1.5);
    if (page_->y < before) draw_head();
    draw(rows[r], false);
  }
  page_->y += 0.6 * kText;
}

void PdfDocument::add_picture(const std::string& heading, const Picture& picture, const std::string& caption) {
  const double scale = std::min((kRight - kLeft) / picture.width, kMaxPictureHeight / picture.height);
  const double height = scale * picture.height;
  page_->need(kHeading * 2.5 + height + 2.5 * kText * kLine);
  add_heading(heading);
  CairoSurface image(cairo_image_surface_create(CAIRO_FORMAT_RGB24, picture.width, picture.height));
  unsigned char* const pixels = cairo_image_surface_get_data(image.get());
  if (!pixels) throw std::bad_alloc();
  const int stride = cairo_image_surface_get_stride(image.get());
  const std::uint8_t* rgb = picture.rgb.data();
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x, rgb += 3) {
      const std::uint32_t pixel =
          static_cast<std::uint32_t>(rgb[0]) << 16 | static_cast<std::uint32_t>(rgb[1]) << 8 | rgb[2];
      std::memcpy(pixels + static_cast<std::ptrdiff_t>(y) * stride + 4 * static_cast<std::ptrdiff_t>(x), &pixel, 4);
    }
  cairo_surface_mark_dirty(image.get());
  cairo_t* const cairo = page_->cairo();
  cairo_save(cairo);
  cairo_translate(cairo, kLeft, page_->y);
  cairo_scale(cairo, scale, scale);
  cairo_set_source_surface(cairo, image.get(), 0, 0);
  cairo_paint(cairo);
  cairo_restore(cairo);
  page_->y += height;
  page_->set_font(false);
  for (const std::string& line : page_->lines_of(caption, kSmall, kRight - kLeft)) {
    page_->y += kSmall * kLine;
    page_->write(line, kLeft, page_->y, kSmall);
  }
  page_->y += kSmall;
}

std::string PdfDocument::finish() { return page_->finish(); }

}  // namespace simplexseg
