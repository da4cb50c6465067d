// SPDX-License-Identifier: Apache-2.0
#include "gui/window/time_point_dialog.h"

#include <QDialogButtonBox>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "core/number_text.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/panels/plot_picture.h"
#include "gui/window/file_actions.h"
#include "image/measurement.h"

namespace simplexseg {
namespace {
constexpr int kPictureHeight = 260;

/// Objects of all time points, each as it is at its first one.
std::vector<TimePointObject> all_objects(const std::vector<TimePoint>& points) {
  std::vector<TimePointObject> all;
  for (const TimePoint& point : points)
    for (const TimePointObject& object : point.objects)
      if (std::ranges::find(all, object.name, &TimePointObject::name) == all.end()) all.push_back(object);
  return all;
}

/// Object of a time point; null if it was not carried so far.
const TimePointObject* find_object(const TimePoint& point, const std::string& name) {
  const auto found = std::ranges::find(point.objects, name, &TimePointObject::name);
  return found == point.objects.end() ? nullptr : &*found;
}

}  // namespace

TimePointDialog::TimePointDialog(Workbench& workbench, FileActions& files, std::vector<TimePoint> points,
                                 QWidget* parent)
    : QDialog(parent),
      files_(files),
      points_(std::move(points)),
      picture_(new PlotPicture(this, [this] { picture_->show_plot(curve_plot(points_)); })),
      table_(new QTableWidget(this)) {
  setObjectName("time_point_dialog");
  setWindowTitle(tr("Time points"));
  auto* column = new QVBoxLayout(this);
  picture_->setMinimumHeight(kPictureHeight);
  picture_->setAccessibleName(tr("Volume against time"));
  column->addWidget(picture_, 1);
  auto* names = new QLabel(summary(), this);
  names->setObjectName("time_point_summary");
  names->setTextFormat(Qt::RichText);
  names->setWordWrap(true);
  column->addWidget(names);
  table_->setObjectName("time_point_table");
  table_->setAccessibleName(tr("Time points"));
  fill_table();
  column->addWidget(table_, 1);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, this);
  auto* open = buttons->addButton(tr("&Open scene"), QDialogButtonBox::ActionRole);
  open->setObjectName("open_time_point");
  auto* save = buttons->addButton(tr("&Save curve..."), QDialogButtonBox::ActionRole);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(open, &QPushButton::clicked, this, [this] { open_scene(table_->currentRow()); });
  connect(save, &QPushButton::clicked, this, [this, &workbench] {
    choose_and_save_plot(this, files_.suggested_path("-curve", ".png"), workbench,
                         [this](const QString& path) { save_plot(path, curve_plot(points_), curve_csv(points_)); });
  });
  connect(table_, &QTableWidget::cellActivated, this, [this](int row) { open_scene(row); });
  resize(620, 640);
  fit_on_screen(*this);
}

void TimePointDialog::fill_table() {
  const std::vector<TimePointObject> objects = all_objects(points_);
  QStringList titles{tr("Time point"), tr("Time (s)")};
  for (const TimePointObject& object : objects) titles << text(object.name);
  table_->setColumnCount(static_cast<int>(titles.size()));
  table_->setHorizontalHeaderLabels(titles);
  table_->setRowCount(static_cast<int>(points_.size()));
  for (std::size_t row = 0; row < points_.size(); ++row) {
    const TimePoint& point = points_[row];
    QStringList texts{QString::number(point.number), point.time_s ? text(general_text(*point.time_s, 5)) : "-"};
    for (const TimePointObject& object : objects) {
      const TimePointObject* const here = find_object(point, object.name);
      texts << (here ? text(volume_text(1000 * here->measures.volume_ml)) : tr("none"));
    }
    for (int n = 0; n < texts.size(); ++n) {
      auto* cell = new QTableWidgetItem(texts[n]);
      cell->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
      table_->setItem(static_cast<int>(row), n, cell);
    }
  }
  make_read_only(*table_);
  table_->verticalHeader()->hide();
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->resizeColumnsToContents();
  table_->setToolTip(tr("A double click opens the scene of a time point"));
  table_->selectRow(0);
}

QString TimePointDialog::summary() const {
  QStringList lines;
  for (const TimePointObject& object : all_objects(points_)) {
    std::vector<std::pair<double, int>> course;  // volume and time point
    for (const TimePoint& point : points_)
      if (const TimePointObject* const here = find_object(point, object.name))
        course.emplace_back(here->measures.volume_ml, point.number);
    const auto [least, most] = std::ranges::minmax_element(course);
    lines << legend_entry(object.colour, object.name,
                          tr("largest %1 at time point %2, smallest %3 at %4 (%5% less)")
                              .arg(text(volume_text(1000 * most->first)))
                              .arg(most->second)
                              .arg(text(volume_text(1000 * least->first)))
                              .arg(least->second)
                              .arg(most->first > 0 ? 100 * (1 - least->first / most->first) : 0, 0, 'f', 1));
  }
  return lines.join("<br>");
}

void TimePointDialog::open_scene(int row) {
  if (row >= 0 && row < static_cast<int>(points_.size()))
    files_.open(QString::fromStdString(points_[static_cast<std::size_t>(row)].scene));
}

}  // namespace simplexseg
