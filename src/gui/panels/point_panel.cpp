// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/point_panel.h"

#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QSignalBlocker>
#include <QTreeWidget>
#include <QVBoxLayout>

#include "gui/input/key_map.h"
#include "gui/look/point_style.h"
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
  list_->setAccessibleName(tr("Points"));
  list_->setColumnCount(5);
  list_->setHeaderLabels({tr("Segmentation"), tr("Kind"), tr("x"), tr("y"), tr("z")});
  for (int axis = 0; axis < 3; ++axis) list_->headerItem()->setToolTip(2 + axis, tr("Patient coordinate (LPS), mm"));
  list_->header()->setSectionResizeMode(QHeaderView::ResizeToContents);
  list_->header()->setSectionResizeMode(0, QHeaderView::Stretch);
  list_->header()->setStretchLastSection(false);
  list_->setRootIsDecorated(false);
  list_->setToolTip(tr("Select a point to move the crosshair to it"));
  layout->addWidget(list_, 1);
  auto* hint =
      new QLabel(tr("In a slice, Shift + left click or a drag of the contour adds a boundary point to the active "
                    "segmentation. I or O marks the place under the mouse as inside or outside."),
                 this);
  hint->setWordWrap(true);
  set_role(hint, "dim");
  layout->addWidget(hint);
  delete_ = new QPushButton(tr("Delete point"), this);
  delete_->setToolTip(tr("Delete the selected point; it no longer affects the segmentation"));
  layout->addWidget(delete_);

  connect(delete_, &QPushButton::clicked, this, [this] {
    if (workbench_.view.selected_point) workbench_.apply(DeletePoint{workbench_.view.selected_point});
  });
  // A click on the row already selected also moves the crosshair.
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
  const UserPoint* point = row ? workbench_.scene().find_point(id_of(row)) : nullptr;
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
  const int decimals = workbench_.has_volume() ? position_decimals(workbench_.session().volume().geometry()) : 1;
  QTreeWidgetItem* selected = nullptr;
  for (int p = 0; p < count; ++p) {
    const UserPoint& point = scene.points[p];
    QTreeWidgetItem* row = list_->topLevelItem(p);
    row->setData(0, Qt::UserRole, point.id);
    if (const MeshItem* item = scene.find_mesh(point.mesh)) {
      row->setText(0, QString::fromStdString(item->name));
      row->setToolTip(0, row->text(0));
      row->setIcon(0, swatch(item->colour));
      row->setIcon(1, handle_icon(point.kind, item->colour));
    }
    // The number of strokes, or the last word of a long title, on a second line leaves space for the name.
    QString kind = title_of(point);
    row->setToolTip(1, kind);
    constexpr qsizetype kLongTitle = 14;  // characters
    if (point.is_lasso())
      kind.replace(kind.lastIndexOf(", "), 2, "\n");
    else if (kind.size() > kLongTitle && kind.contains(' '))
      kind.replace(kind.lastIndexOf(' '), 1, "\n");
    row->setText(1, kind);
    for (int axis = 0; axis < 3; ++axis) {
      row->setText(2 + axis, QString::number(point.position_mm[axis], 'f', decimals));
      row->setTextAlignment(2 + axis, Qt::AlignRight | Qt::AlignVCenter);
    }
    if (point.id == workbench_.view.selected_point) selected = row;
  }
  list_->setCurrentItem(selected);
  const bool locked = is_locked(scene, shown_selection_);
  set_enabled(delete_, selected && !locked,
              locked       ? why_locked()
              : count == 0 ? tr("There are no points yet")
                           : tr("No point is selected"));
}

}  // namespace simplexseg
