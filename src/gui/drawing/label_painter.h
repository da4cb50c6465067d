// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QColor>
#include <QFont>
#include <QRectF>
#include <QString>
#include <vector>

#include "gui/drawing/painters.h"

namespace simplexseg {

/// Text with a dark halo, readable on any image.
struct Label {
  QRectF box;     ///< rectangle of the text, logical pixels of the view
  int alignment;  ///< Qt::Alignment of the text in the box
  QString text;
  QColor colour;
  bool bold = true;
  bool operator==(const Label&) const = default;
};

/// Draws labels from a texture. Rendering text is slow, so the texture is updated only when a label or the size of the
/// view has changed.
class LabelPainter {
 public:
  void create();
  void destroy();
  void draw(const QSize& size_px, double pixel_ratio, const QFont& font, const std::vector<Label>& labels);

 private:
  void render(const QFont& font);

  Program program_;
  unsigned vertex_array_ = 0, rectangles_ = 0, texture_ = 0;
  QSize size_px_, texture_px_;
  double pixel_ratio_ = 1;
  std::vector<Label> labels_;
  int rectangle_count_ = 0;
};

}  // namespace simplexseg
