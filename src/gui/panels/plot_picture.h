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

/// Widget that shows a plot, or a text while there is no plot.
class PlotPicture : public QWidget {
 public:
  /// `redraw` is called when the size or the theme has changed.
  PlotPicture(QWidget* parent, std::function<void()> redraw);
  /// Shows the plot without its title and the names of the series, which the panel shows beside it.
  void show_plot(Plot plot);
  void show_text(const QString& text);
  /// Picture of the plot; null while a text is shown.
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

/// Entry of a legend below a plot, in HTML: a square of a colour, a name, and a value.
QString legend_entry(const Colour& colour, const std::string& name, const QString& value);
/// Adds the quantities of a run that can be plotted, each with a tooltip: residual, surface error.
void add_quantities(QComboBox& choices);
/// Writes the plot as a picture (.png, .svg), or `csv` if the name ends in .csv. Throws Error if the file cannot be
/// written.
void save_plot(const QString& path, const Plot& plot, const std::string& csv);
/// Opens a file dialog with the name `suggestion`, passes the chosen file to `save`, and reports success or failure.
void choose_and_save_plot(QWidget* parent, const QString& suggestion, Workbench& workbench,
                          const std::function<void(const QString&)>& save);

}  // namespace simplexseg
