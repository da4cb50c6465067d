// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/intensity_plot.h"

#include <QMouseEvent>
#include <QPainter>
#include <algorithm>
#include <cmath>
#include <utility>

namespace simplexseg {
namespace {

constexpr int kMargin = 6;      // beside the plot, so that a handle at its end can be grasped, logical pixels
constexpr double kAtEnd = 1.5;  // distance from the end of the plot at which a limit is removed, logical pixels
constexpr int kShade = 110;     // alpha outside the range

}  // namespace

IntensityPlot::IntensityPlot(QWidget* parent) : QWidget(parent) {
  setAccessibleName(tr("Histogram of intensities"));
  setToolTip(
      tr("Drag a handle to limit the intensities of the segmentation; to the end of the plot to remove the limit"));
  setCursor(Qt::SplitHCursor);
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Expanding);
}

void IntensityPlot::show_histogram(IntensityHistogram image) {
  image_ = std::move(image);
  update();
}

void IntensityPlot::show_object(std::vector<std::size_t> counts, const QColor& colour) {
  object_ = std::move(counts);
  object_colour_ = colour;
  update();
}

void IntensityPlot::show_range(const IntensityRange& range) {
  if (dragged_ != Handle::None) return;  // the user's range is newer
  range_ = range;
  update();
}

double IntensityPlot::x_of(double intensity) const {
  const double share = (intensity - image_.range.low) / (image_.range.high - image_.range.low);
  return kMargin + std::clamp(share, 0.0, 1.0) * (width() - 2 * kMargin);
}

double IntensityPlot::intensity_at(double x) const {
  const double share = std::clamp((x - kMargin) / std::max(1, width() - 2 * kMargin), 0.0, 1.0);
  return image_.range.low + share * (image_.range.high - image_.range.low);
}

void IntensityPlot::paint_counts(QPainter& painter, const std::vector<std::size_t>& counts,
                                 const QColor& colour) const {
  if (counts.empty()) return;
  const double most = std::log1p(static_cast<double>(*std::ranges::max_element(counts)));
  if (!(most > 0)) return;
  const double column = (width() - 2.0 * kMargin) / static_cast<double>(counts.size());
  QPolygonF outline{QPointF(kMargin, height())};
  for (std::size_t n = 0; n < counts.size(); ++n) {
    const double top = height() - (height() - 4) * std::log1p(static_cast<double>(counts[n])) / most;
    outline << QPointF(kMargin + column * static_cast<double>(n), top)
            << QPointF(kMargin + column * static_cast<double>(n + 1), top);
  }
  outline << QPointF(width() - kMargin, height());
  painter.setPen(Qt::NoPen);
  painter.setBrush(colour);
  painter.drawPolygon(outline);
}

void IntensityPlot::changeEvent(QEvent* event) {
  QWidget::changeEvent(event);
  if (event->type() != QEvent::EnabledChange || isEnabled()) return;
  if (std::exchange(dragged_, Handle::None) != Handle::None) emit cancelled();
}

void IntensityPlot::paintEvent(QPaintEvent* event) {
  QWidget::paintEvent(event);
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.fillRect(rect(), palette().base());
  if (image_.counts.empty()) return;
  QColor grey = palette().color(isEnabled() ? QPalette::Active : QPalette::Disabled, QPalette::Text);
  grey.setAlpha(90);
  paint_counts(painter, image_.counts, grey);
  QColor tint = object_colour_;
  tint.setAlpha(150);
  paint_counts(painter, object_, tint);
  if (!isEnabled()) return;
  const double low = x_of(range_.low), high = x_of(range_.high);
  QColor shade = palette().color(QPalette::Base);
  shade.setAlpha(kShade);
  painter.fillRect(QRectF(0, 0, low, height()), shade);
  painter.fillRect(QRectF(high, 0, width() - high, height()), shade);
  for (const double x : {low, high}) {
    painter.setPen(QPen(palette().color(QPalette::Highlight), 2));
    painter.drawLine(QPointF(x, 0), QPointF(x, height()));
    painter.setBrush(palette().highlight());
    painter.drawEllipse(QPointF(x, height() / 2.0), 4, 4);
  }
}

void IntensityPlot::drag_to(double x) {
  const double interval =
      (image_.range.high - image_.range.low) / static_cast<double>(std::max<std::size_t>(1, image_.counts.size()));
  if (dragged_ == Handle::Low) {
    const double most = std::min(range_.high, image_.range.high) - interval;
    range_.low = x <= kMargin + kAtEnd ? IntensityRange{}.low : std::min(intensity_at(x), most);
  } else {
    const double least = std::max(range_.low, image_.range.low) + interval;
    range_.high = x >= width() - kMargin - kAtEnd ? IntensityRange{}.high : std::max(intensity_at(x), least);
  }
  update();
  emit dragged();
}

void IntensityPlot::mousePressEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton || image_.counts.empty()) return;
  const double x = event->position().x(), to_low = std::abs(x - x_of(range_.low)),
               to_high = std::abs(x - x_of(range_.high));
  dragged_ = to_low < to_high || (to_low == to_high && x < x_of(range_.low)) ? Handle::Low : Handle::High;
  drag_to(x);
}

void IntensityPlot::mouseMoveEvent(QMouseEvent* event) {
  if (dragged_ != Handle::None) drag_to(event->position().x());
}

void IntensityPlot::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton || std::exchange(dragged_, Handle::None) == Handle::None) return;
  emit dropped();
}

}  // namespace simplexseg
