// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QImage>
#include <QWidget>
#include <functional>

#include "session/plot.h"

namespace simplexseg {

/// A drawn plot, or a text where there is none.
class PlotPicture : public QWidget {
 public:
  /// `resized`: draws anew.
  PlotPicture(QWidget* parent, std::function<void()> resized);
  /// Without title and names of series: what stands beside the picture says them.
  void show_plot(Plot plot);
  void show_text(const QString& text);
  /// Null while a text is shown.
  const QImage& image() const { return image_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;
  void paintEvent(QPaintEvent* event) override;

 private:
  std::function<void()> resized_;
  QImage image_;
  QString text_;
};

}  // namespace simplexseg
