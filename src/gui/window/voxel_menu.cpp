// SPDX-License-Identifier: Apache-2.0
#include "gui/window/voxel_menu.h"

#include <QCoreApplication>
#include <QInputDialog>

#include "gui/input/key_map.h"
#include "gui/look/point_style.h"
#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

VoxelMenu::VoxelMenu(Workbench& workbench, QWidget* parent)
    : QMenu(tr("&Change voxels"), parent), workbench_(workbench) {
  setObjectName("voxel_menu");
  setToolTipsVisible(true);
  for (const VoxelEditInfo& info : voxel_edits())
    if (!info.uses_stroke) add_edit(info);
  connect(&workbench_, &Workbench::scene_changed, this, &VoxelMenu::enable);
  enable();
}

void VoxelMenu::add_edit(const VoxelEditInfo& info) {
  const VoxelEdit edit = info.edit;
  if (info.uses_other) {
    QMenu* const others = addMenu(title_of(edit));
    others->setObjectName(info.name);
    others->menuAction()->setObjectName(info.name);
    connect(others, &QMenu::aboutToShow, this, [this, others, edit] { list_others(*others, edit); });
  } else {
    const bool asks = info.size.name[0] != '\0';
    QAction* const entry = addAction(asks ? title_of(edit) + "..." : title_of(edit));
    entry->setObjectName(info.name);
    connect(entry, &QAction::triggered, this, [this, edit, asks] {
      if (asks)
        ask_size(info_of(edit));
      else
        workbench_.apply(EditVoxels{workbench_.view.active_mesh, edit});
    });
  }
  actions().back()->setToolTip(QCoreApplication::translate("Edits", info.doc));
}

void VoxelMenu::ask_size(const VoxelEditInfo& info) {
  auto* dialog = new QInputDialog(parentWidget()->window());
  dialog->setObjectName("voxel_size");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(title_of(info.edit));
  dialog->setInputMode(QInputDialog::DoubleInput);
  const QString unit = QString(info.size.unit).replace("mm3", "mm\u00b3");
  dialog->setLabelText(tr("%1\nUnit: %2").arg(QCoreApplication::translate("Edits", info.size.doc), unit));
  dialog->setDoubleDecimals(2);
  dialog->setDoubleRange(info.size.minimum, info.size.maximum);
  dialog->setDoubleValue(info.size.default_value);
  const ItemId mesh = workbench_.view.active_mesh;
  connect(dialog, &QInputDialog::doubleValueSelected, this, [this, mesh, edit = info.edit](double size) {
    workbench_.apply(EditVoxels{mesh, edit, size});
  });
  dialog->open();
}

void VoxelMenu::list_others(QMenu& menu, VoxelEdit edit) {
  menu.clear();
  const ItemId mesh = workbench_.view.active_mesh;
  for (const MeshItem& item : workbench_.scene().meshes) {
    if (item.id == mesh) continue;
    QAction* const entry = menu.addAction(QString::fromStdString(item.name).replace("&", "&&"));
    connect(entry, &QAction::triggered, this, [this, mesh, edit, other = item.id] {
      workbench_.apply(EditVoxels{mesh, edit, 0, other});
    });
  }
}

void VoxelMenu::enable() {
  const MeshItem* const active = workbench_.active_mesh();
  const bool several = workbench_.scene().meshes.size() > 1, locked = active && active->locked;
  const QString why =
      locked ? why_locked() : tr("There is no segmentation yet: place a seed first (%1)").arg(key_hint(Act::ToolSeed));
  for (const VoxelEditInfo& info : voxel_edits())
    for (QAction* entry : actions())
      if (entry->objectName() == info.name)
        set_enabled(entry, active && !locked && (several || !info.uses_other),
                    active && !locked ? tr("There is no other segmentation") : why);
}

}  // namespace simplexseg
