// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/point_panel.h"

#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QSignalBlocker>
#include <QTreeWidget>
#include <QVBoxLayout>

#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
ItemId id_of(const QTreeWidgetItem* row) { return row->data(0, Qt::UserRole).toUInt(); }
}  // namespace

PointPanel::PointPanel(Workbench& workbench, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  list_ = new QTreeWidget(this);
  list_->setColumnCount(4);
  list_->setHeaderLabels({tr("Mesh"), tr("x"), tr("y"), tr("z (mm, LPS)")});
  list_->header()->setSectionResizeMode(QHeaderView::ResizeToContents);
  list_->header()->setSectionResizeMode(0, QHeaderView::Stretch);
  list_->header()->setStretchLastSection(false);
  list_->setRootIsDecorated(false);
  list_->setToolTip(tr("Select a point: the crosshair goes there"));
  layout->addWidget(list_, 1);
  auto* hint = new QLabel(tr("Shift + left click in a slice pulls the active mesh to that place."), this);
  hint->setWordWrap(true);
  hint->setStyleSheet("color: #969ca4;");
  layout->addWidget(hint);
  delete_ = new QPushButton(tr("Delete point"), this);
  delete_->setToolTip(tr("Delete the selected point; the mesh is no longer pulled there"));
  layout->addWidget(delete_);

  connect(delete_, &QPushButton::clicked, this, [this] {
    if (workbench_.view.selected_point) workbench_.apply(DeleteAttractionPoint{workbench_.view.selected_point});
  });
  // Also a click on the row that is selected already goes there.
  connect(list_, &QTreeWidget::itemClicked, this, [this](QTreeWidgetItem*) { follow_selection(); });
  connect(list_, &QTreeWidget::currentItemChanged, this, [this] { follow_selection(); });
  connect(&workbench_, &Workbench::scene_changed, this, &PointPanel::refresh);
  connect(&workbench_, &Workbench::view_changed, this, [this] {
    if (shown_selection_ != workbench_.view.selected_point) refresh();
  });
  refresh();
}

void PointPanel::follow_selection() {
  const QTreeWidgetItem* row = list_->currentItem();
  const AttractionPoint* point = row ? workbench_.scene().find_point(id_of(row)) : nullptr;
  if (!point) return;
  workbench_.view.selected_point = point->id;
  workbench_.set_crosshair(point->position_mm);
}

void PointPanel::refresh() {
  const QSignalBlocker blocker(list_);
  shown_selection_ = workbench_.view.selected_point;
  const Scene& scene = workbench_.scene();
  const int count = static_cast<int>(scene.points.size());
  while (list_->topLevelItemCount() > count) delete list_->takeTopLevelItem(list_->topLevelItemCount() - 1);
  while (list_->topLevelItemCount() < count) list_->addTopLevelItem(new QTreeWidgetItem);
  QTreeWidgetItem* selected = nullptr;
  for (int p = 0; p < count; ++p) {
    const AttractionPoint& point = scene.points[p];
    QTreeWidgetItem* row = list_->topLevelItem(p);
    row->setData(0, Qt::UserRole, point.id);
    if (const MeshItem* item = scene.find_mesh(point.mesh)) {
      row->setText(0, QString::fromStdString(item->name));
      row->setIcon(0, swatch(item->colour));
    }
    for (int axis = 0; axis < 3; ++axis) {
      row->setText(1 + axis, QString::number(point.position_mm[axis], 'f', 1));
      row->setTextAlignment(1 + axis, Qt::AlignRight | Qt::AlignVCenter);
    }
    if (point.id == workbench_.view.selected_point) selected = row;
  }
  list_->setCurrentItem(selected);
  set_enabled(delete_, selected, count == 0 ? tr("There is no point yet") : tr("No point is selected"));
}

}  // namespace simplexseg
