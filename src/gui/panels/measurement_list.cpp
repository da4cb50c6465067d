// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/measurement_list.h"

#include <QHeaderView>
#include <QSignalBlocker>

#include "gui/look/symbols.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

ItemId id_in(const QTreeWidgetItem* row) { return row->data(0, Qt::UserRole).toUInt(); }

QIcon icon_of_kind(MeasurementKind kind) {
  return icon_of(kind == MeasurementKind::Ruler   ? Symbol::Ruler
                 : kind == MeasurementKind::Angle ? Symbol::Angle
                                                  : Symbol::Ellipse);
}

}  // namespace

MeasurementList::MeasurementList(Workbench& workbench, QWidget* parent) : QTreeWidget(parent), workbench_(workbench) {
  setObjectName("measurement_list");
  setAccessibleName(tr("Rulers, angles and ellipses"));
  setColumnCount(2);
  setHeaderLabels({tr("Measurement"), tr("Value")});
  header()->setSectionResizeMode(0, QHeaderView::ResizeToContents);
  setRootIsDecorated(false);
  setEditTriggers(QAbstractItemView::DoubleClicked | QAbstractItemView::EditKeyPressed);
  setToolTip(tr("Select a measurement to move the crosshair to it; double-click its name to rename it"));
  constexpr int kRows = 4;
  setMaximumHeight((kRows + 1) * (fontMetrics().height() + 10));
  connect(this, &QTreeWidget::itemClicked, this, [this] { follow_selection(); });
  connect(this, &QTreeWidget::currentItemChanged, this, [this] { follow_selection(); });
  connect(this, &QTreeWidget::itemChanged, this, [this](QTreeWidgetItem* row, int column) {
    if (column == 0) rename(row);
  });
  connect(&workbench_, &Workbench::scene_changed, this, &MeasurementList::refresh);
  connect(&workbench_, &Workbench::view_changed, this, [this] {
    if (shown_selection_ != workbench_.view.selected_measurement()) refresh();
  });
  refresh();
}

void MeasurementList::follow_selection() {
  const QTreeWidgetItem* row = currentItem();
  const Measurement* const measurement = row ? workbench_.scene().find_measurement(id_in(row)) : nullptr;
  if (!measurement) return;
  workbench_.view.last_measurement = measurement->id, workbench_.view.selected_point = 0;
  workbench_.set_crosshair(measurement->points_mm[measurement->kind == MeasurementKind::Angle ? 1 : 0]);
}

void MeasurementList::rename(QTreeWidgetItem* row) {
  const Measurement* const measurement = workbench_.scene().find_measurement(id_in(row));
  const std::string name = row->text(0).toStdString();
  if (!measurement || name == measurement->name) return;
  // Deferred: the list must not change while it reports a change.
  QMetaObject::invokeMethod(
      this,
      [this, id = measurement->id, name] {
        if (!workbench_.apply(RenameMeasurement{id, name})) refresh();
      },
      Qt::QueuedConnection);
}

void MeasurementList::refresh() {
  const QSignalBlocker blocker(this);
  const Scene& scene = workbench_.scene();
  shown_selection_ = workbench_.view.selected_measurement();
  setVisible(!scene.measurements.empty());
  const int count = static_cast<int>(scene.measurements.size());
  while (topLevelItemCount() > count) delete takeTopLevelItem(topLevelItemCount() - 1);
  while (topLevelItemCount() < count) addTopLevelItem(new QTreeWidgetItem);
  QTreeWidgetItem* selected = nullptr;
  for (int m = 0; m < count; ++m) {
    const Measurement& measurement = scene.measurements[static_cast<std::size_t>(m)];
    QTreeWidgetItem* row = topLevelItem(m);
    row->setFlags(row->flags() | Qt::ItemIsEditable);
    row->setData(0, Qt::UserRole, measurement.id);
    row->setText(0, QString::fromStdString(measurement.name));
    row->setIcon(0, icon_of_kind(measurement.kind));
    QStringList lines;
    for (const std::string& line :
         lines_of(values_of(measurement, workbench_.session().volume()), workbench_.intensity_unit()))
      lines << QString::fromStdString(line);
    row->setText(1, lines.join(", "));
    row->setToolTip(1, row->text(1));
    if (measurement.id == shown_selection_) selected = row;
  }
  setCurrentItem(selected);
}

}  // namespace simplexseg
