// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QImage>
#include <QWidget>
#include <functional>
#include <string>

#include "session/plot.h"

class QComboBox;

namespace simplexseg {

class Workbench;

/// A drawn plot, or a text where there is none.
class PlotPicture : public QWidget {
 public:
  /// `redraw`: called when the size or the theme has changed.
  PlotPicture(QWidget* parent, std::function<void()> redraw);
  /// Without title and names of series: what stands beside the picture says them.
  void show_plot(Plot plot);
  void show_text(const QString& text);
  /// Null while a text is shown.
  const QImage& image() const { return image_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;
  void changeEvent(QEvent* event) override;
  void paintEvent(QPaintEvent* event) override;

 private:
  std::function<void()> redraw_;
  QImage image_;
  QString text_;
};

/// What is plotted of a run, with a sentence on each: residuals, then the surface's error.
void add_quantities(QComboBox& choices);
/// Writes the plot as a picture (.png, .svg), or `csv` where the name ends in .csv. Throws Error as write_plot().
void save_plot(const QString& path, const Plot& plot, const std::string& csv);
/// Asks for a file, `offered` at first, hands it to `save`, and tells the user what came of it.
void choose_and_save_plot(QWidget* parent, const QString& offered, Workbench& workbench,
                          const std::function<void(const QString&)>& save);

}  // namespace simplexseg
