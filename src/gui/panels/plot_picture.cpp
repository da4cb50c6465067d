// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/plot_picture.h"

#include <QPainter>
#include <utility>

#include "gui/look/theme.h"
#include "io/plot_io.h"

namespace simplexseg {

PlotPicture::PlotPicture(QWidget* parent, std::function<void()> resized)
    : QWidget(parent), resized_(std::move(resized)) {
  setMinimumSize(160, 120);
}

void PlotPicture::show_plot(Plot plot) {
  plot.title.clear();
  for (PlotSeries& series : plot.series) series.name.clear();
  const double scale = devicePixelRatioF();
  const QSize size = (QSizeF(this->size()) * scale).toSize();
  const std::vector<std::uint8_t> pixels = draw_plot(plot, size.width(), size.height(), scale, PlotTheme::Dark);
  image_ = QImage(pixels.data(), size.width(), size.height(), QImage::Format_RGBA8888).copy();
  text_.clear();
  update();
}

void PlotPicture::show_text(const QString& text) {
  image_ = {};
  text_ = text;
  update();
}

void PlotPicture::resizeEvent(QResizeEvent*) { resized_(); }

void PlotPicture::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  if (!image_.isNull()) {
    painter.drawImage(rect(), image_);
    return;
  }
  painter.fillRect(rect(), palette().color(QPalette::Base));
  painter.setPen(theme::shades().dim);
  painter.drawText(rect().adjusted(16, 16, -16, -16), Qt::AlignCenter | Qt::TextWordWrap, text_);
}

}  // namespace simplexseg
