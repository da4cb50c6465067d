// SPDX-License-Identifier: Apache-2.0
#include "gui/views/slice_menu.h"

#include <QMenu>
#include <tuple>

#include "gui/input/key_map.h"
#include "gui/look/point_style.h"
#include "gui/look/widgets.h"
#include "gui/views/measure_tool.h"
#include "gui/views/slice_hits.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

void show_slice_menu(Workbench& workbench, SliceView& view, MeasureTool& measure_tool, const QPointF& pixel,
                     const QPoint& global, const std::function<void(MarkKind)>& add_point) {
  const Eigen::Vector3d world = view.world_of(pixel);
  const ItemId point = point_in_slice(workbench, view, pixel), mesh = mesh_in_slice(workbench, view, pixel);
  QMenu menu(&view);
  menu.setToolTipsVisible(true);
  if (point) {
    QAction* const erase =
        menu.addAction(SliceView::tr("Delete this point"), [&, point] { workbench.apply(DeletePoint{point}); });
    if (is_locked(workbench.scene(), point)) set_enabled(erase, false, why_locked());
    menu.addSeparator();
  }
  measure_tool.add_entries(menu, pixel);
  const std::tuple<MarkKind, QString, Act> kinds[] = {
      {MarkKind::Boundary, SliceView::tr("Boundary point here: the surface passes here"), Act::AddPoint},
      {MarkKind::Inside, SliceView::tr("Inside point here: belongs to the structure"), Act::AddInside},
      {MarkKind::Outside, SliceView::tr("Outside point here: does not belong to the structure"), Act::AddOutside}};
  for (const auto& [kind, text, act] : kinds) {
    QAction* add = menu.addAction(text, [&, kind = kind] { add_point(kind); });
    if (has_key(act)) add->setShortcut(KeyMap::shared().keys().key_of(act));
    const MeshItem* const active = workbench.active_mesh();
    if (!active || active->locked)
      set_enabled(
          add, false,
          active ? why_locked()
                 : SliceView::tr("A point needs a segmentation: place a seed first (%1)").arg(key_hint(Act::ToolSeed)));
  }
  if (const MeshItem* item = workbench.scene().find_mesh(mesh); item && mesh != workbench.view.active_mesh) {
    menu.addAction(SliceView::tr("Make '%1' active").arg(QString::fromStdString(item->name)),
                   [&, mesh] { workbench.set_active_mesh(mesh); });
  }
  menu.addAction(SliceView::tr("Crosshair here"), [&, world] { workbench.set_crosshair(world); });
  menu.exec(global);
}

}  // namespace simplexseg
