// SPDX-License-Identifier: Apache-2.0
#include "io/picture/cairo_drawing.h"

#include <cairo.h>

namespace simplexseg {

void CairoRelease::operator()(cairo_t* context) const { cairo_destroy(context); }
void CairoRelease::operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }

double text_width(cairo_t* cairo, const std::string& text, double size) {
  cairo_set_font_size(cairo, size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, text.c_str(), &extents);
  return extents.x_advance;
}

std::string fitted_text(cairo_t* cairo, std::string text, double size, double width) {
  if (text_width(cairo, text, size) <= width) return text;
  while (!text.empty() && text_width(cairo, text + "…", size) > width) {
    while (!text.empty() && (text.back() & 0xc0) == 0x80) text.pop_back();
    if (!text.empty()) text.pop_back();
  }
  return text + "…";
}

}  // namespace simplexseg
