// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/label_painter.h"

#include <GL/glew.h>

#include <QFontMetricsF>
#include <QImage>
#include <QPainter>
#include <algorithm>

namespace simplexseg {
namespace {

void draw_label(QPainter& painter, const Label& label) {
  painter.setPen(QColor(0, 0, 0, 190));
  for (const QPointF offset : {QPointF(1, 1), QPointF(-1, 1), QPointF(1, -1), QPointF(-1, -1)}) {
    painter.drawText(label.box.translated(offset), label.alignment, label.text);
  }
  painter.setPen(label.colour);
  painter.drawText(label.box, label.alignment, label.text);
}

/// Merges overlapping rectangles, because text that is drawn twice would be too dark.
std::vector<QRect> disjoint(std::vector<QRect> rectangles) {
  for (std::size_t n = 0; n < rectangles.size();) {
    const auto other = std::find_if(rectangles.begin() + static_cast<std::ptrdiff_t>(n) + 1, rectangles.end(),
                                    [&](const QRect& r) { return r.intersects(rectangles[n]); });
    if (other == rectangles.end()) {
      ++n;
    } else {
      rectangles[n] |= *other;
      rectangles.erase(other);
      n = 0;  // the merged rectangle may overlap others
    }
  }
  return rectangles;
}

}  // namespace

void LabelPainter::create() {
  program_.create("label.vert", "label.frag");
  glCreateVertexArrays(1, &vertex_array_);
  glCreateBuffers(1, &rectangles_);
  glVertexArrayVertexBuffer(vertex_array_, 0, rectangles_, 0, 4 * sizeof(float));
  glVertexArrayBindingDivisor(vertex_array_, 0, 1);
  glEnableVertexArrayAttrib(vertex_array_, 0);
  glVertexArrayAttribFormat(vertex_array_, 0, 4, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(vertex_array_, 0, 0);
}

void LabelPainter::destroy() {
  program_.destroy();
  glDeleteVertexArrays(1, &vertex_array_);
  glDeleteBuffers(1, &rectangles_);
  glDeleteTextures(1, &texture_);
  vertex_array_ = rectangles_ = texture_ = 0;
  texture_px_ = {};
  labels_.clear();
  rectangle_count_ = 0;
}

void LabelPainter::draw(const QSize& size_px, double pixel_ratio, const QFont& font, const std::vector<Label>& labels) {
  if (size_px != size_px_ || pixel_ratio != pixel_ratio_ || labels != labels_) {
    size_px_ = size_px;
    pixel_ratio_ = pixel_ratio;
    labels_ = labels;
    render(font);
  }
  if (rectangle_count_ == 0) return;
  program_.set("viewport_px",
               Eigen::Vector2f(static_cast<float>(size_px.width()), static_cast<float>(size_px.height())));
  program_.use();
  glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glBindTextureUnit(0, texture_);
  glBindVertexArray(vertex_array_);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, rectangle_count_);
}

void LabelPainter::render(const QFont& font) {
  rectangle_count_ = 0;
  if (labels_.empty() || size_px_.isEmpty()) return;
  QImage picture(size_px_, QImage::Format_ARGB32_Premultiplied);
  picture.fill(Qt::transparent);
  picture.setDevicePixelRatio(pixel_ratio_);
  std::vector<QRect> rectangles;
  {
    QPainter painter(&picture);
    painter.setRenderHint(QPainter::TextAntialiasing);
    for (const Label& label : labels_) {
      QFont label_font = font;
      label_font.setBold(label.bold);
      painter.setFont(label_font);
      draw_label(painter, label);
      const QRectF bounds = painter.boundingRect(label.box, label.alignment, label.text).adjusted(-3, -3, 3, 3);
      const QRectF px(bounds.topLeft() * pixel_ratio_, bounds.size() * pixel_ratio_);
      const QRect inside = px.toAlignedRect() & picture.rect();
      if (!inside.isEmpty()) rectangles.push_back(inside);
    }
  }
  if (texture_px_ != size_px_) {
    glDeleteTextures(1, &texture_);
    glCreateTextures(GL_TEXTURE_2D, 1, &texture_);
    glTextureStorage2D(texture_, 1, GL_RGBA8, size_px_.width(), size_px_.height());
    glTextureParameteri(texture_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    texture_px_ = size_px_;
  }
  std::vector<float> packed;
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<int>(picture.bytesPerLine() / 4));
  for (const QRect& r : disjoint(std::move(rectangles))) {
    glTextureSubImage2D(texture_, 0, r.x(), r.y(), r.width(), r.height(), GL_BGRA, GL_UNSIGNED_BYTE,
                        picture.constScanLine(r.y()) + 4 * static_cast<std::ptrdiff_t>(r.x()));
    for (const int value : {r.x(), r.y(), r.width(), r.height()}) packed.push_back(static_cast<float>(value));
    ++rectangle_count_;
  }
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glNamedBufferData(rectangles_, static_cast<GLsizeiptr>(packed.size() * sizeof(float)), packed.data(), GL_STREAM_DRAW);
}

}  // namespace simplexseg
