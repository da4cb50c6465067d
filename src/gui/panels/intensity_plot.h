// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QColor>
#include <QWidget>

#include "image/intensity_samples.h"

namespace simplexseg {

/// Histogram of an image (logarithmic), and of an object if given, with a handle at each limit of a range. A drag moves
/// the nearer handle; one to the end of the plot removes that limit.
class IntensityPlot : public QWidget {
  Q_OBJECT
 public:
  explicit IntensityPlot(QWidget* parent);
  void show_histogram(IntensityHistogram image);
  /// Shows the histogram of an object in the same intervals; empty: none.
  void show_object(std::vector<std::size_t> counts, const QColor& colour);
  void show_range(const IntensityRange& range);
  const IntensityRange& range() const { return range_; }
  const IntensityHistogram& histogram() const { return image_; }
  /// Horizontal position of an intensity, logical pixels, within the plot.
  double x_of(double intensity) const;
  QSize sizeHint() const override { return {280, 150}; }
  QSize minimumSizeHint() const override { return {120, 70}; }

 signals:
  void dragged();    ///< range() has changed
  void dropped();    ///< the drag has ended
  void cancelled();  ///< the drag has ended because the plot was disabled; range() must be set again

 protected:
  void changeEvent(QEvent* event) override;
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;

 private:
  enum class Handle { None, Low, High };
  double intensity_at(double x) const;
  void drag_to(double x);
  /// Adds the columns of a histogram, scaled to the height of the plot.
  void paint_counts(QPainter& painter, const std::vector<std::size_t>& counts, const QColor& colour) const;

  IntensityHistogram image_;
  std::vector<std::size_t> object_;
  QColor object_colour_;
  IntensityRange range_;
  Handle dragged_ = Handle::None;
};

}  // namespace simplexseg
