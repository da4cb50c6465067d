// SPDX-License-Identifier: Apache-2.0
// What drawings with cairo share; its header is included in sources only.
#pragma once
#include <memory>
#include <string>

typedef struct _cairo cairo_t;
typedef struct _cairo_surface cairo_surface_t;

namespace simplexseg {

struct CairoRelease {
  void operator()(cairo_t* context) const;
  void operator()(cairo_surface_t* surface) const;
};
using CairoContext = std::unique_ptr<cairo_t, CairoRelease>;
using CairoSurface = std::unique_ptr<cairo_surface_t, CairoRelease>;

/// Advance of a text in the current font at a size. Sets the size.
double text_width(cairo_t* cairo, const std::string& text, double size);
/// Text that fits into a width; if necessary, shortened after a whole UTF-8 character, with an ellipsis.
std::string fitted_text(cairo_t* cairo, std::string text, double size, double width);

}  // namespace simplexseg
