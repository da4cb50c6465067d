// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/plot_picture.h"

#include <QComboBox>
#include <QEvent>
#include <QPainter>
#include <utility>

#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/workbench/ask_and_save.h"
#include "io/picture/plot_io.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr int kSavedWidth = 900, kSavedHeight = 600;

}  // namespace

PlotPicture::PlotPicture(QWidget* parent, std::function<void()> redraw) : QWidget(parent), redraw_(std::move(redraw)) {
  setMinimumSize(160, 120);
}

void PlotPicture::show_plot(Plot plot) {
  plot.title.clear();
  for (PlotSeries& series : plot.series) series.name.clear();
  const double scale = devicePixelRatioF();
  const QSize size = (QSizeF(this->size()) * scale).toSize();
  const PlotTheme theme = theme::is_dark() ? PlotTheme::Dark : PlotTheme::Light;
  const std::vector<std::uint8_t> pixels = draw_plot(plot, size.width(), size.height(), scale, theme);
  image_ = QImage(pixels.data(), size.width(), size.height(), QImage::Format_RGBA8888).copy();
  text_.clear();
  update();
}

void PlotPicture::show_text(const QString& text) {
  image_ = {};
  text_ = text;
  update();
}

void PlotPicture::resizeEvent(QResizeEvent*) { redraw_(); }

void PlotPicture::changeEvent(QEvent* event) {
  QWidget::changeEvent(event);
  if (event->type() == QEvent::PaletteChange) redraw_();
}

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

QString legend_entry(const Colour& colour, const std::string& name, const QString& value) {
  return QString("<span style='color:%1'>&#9632;</span> %2&nbsp; <span style='color:%3'>%4</span>")
      .arg(QColor(colour.red, colour.green, colour.blue).name(), text(name).toHtmlEscaped(), theme::shades().dim.name(),
           value);
}

void add_quantities(QComboBox& choices) {
  const auto add = [&](const QString& title, const QString& tip) {
    choices.addItem(title);
    choices.setItemData(choices.count() - 1, tip, Qt::ToolTipRole);
  };
  add(QObject::tr("Residual"),
      QObject::tr("Displacement that the forces still require: root mean square over the vertices of a mesh"));
  add(QObject::tr("Surface error"),
      QObject::tr("Distance of the vertices from the reference surface: mean (solid), 95th percentile (dashed)"));
}

void save_plot(const QString& path, const Plot& plot, const std::string& csv) {
  const std::filesystem::path file_path = to_path(path);
  if (extension_of(file_path) != ".csv") {
    write_plot(file_path, plot, kSavedWidth, kSavedHeight);
    return;
  }
  AtomicFile file(file_path);
  write_bytes(file, csv);
  file.commit();
}

void choose_and_save_plot(QWidget* parent, const QString& suggestion, Workbench& workbench,
                          const std::function<void(const QString&)>& save) {
  ask_and_save(parent, workbench,
               {QObject::tr("Save the plot or its data"), suggestion,
                QObject::tr("Picture (*.png);;Vector graphics (*.svg);;Table (*.csv)")},
               save);
}

}  // namespace simplexseg
