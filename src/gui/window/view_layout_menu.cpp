// SPDX-License-Identifier: Apache-2.0
#include "gui/window/view_layout_menu.h"

#include <QActionGroup>
#include <functional>

#include "gui/look/qt_text.h"
#include "gui/views/slice_view.h"
#include "gui/views/space_view.h"
#include "gui/views/view_grid.h"

namespace simplexseg {

ViewLayoutMenu::ViewLayoutMenu(ViewGrid& views, QWidget* parent) : QMenu(tr("La&yout of views"), parent) {
  setObjectName("view_layout_menu");
  auto* group = new QActionGroup(this);
  const auto add_to = [&](QMenu& menu, QActionGroup& group, const QString& title, const std::function<void()>& choose,
                          const std::function<bool()>& is_shown) {
    QAction* const entry = menu.addAction(title);
    entry->setCheckable(true);
    group.addAction(entry);
    connect(entry, &QAction::triggered, this, choose);
    connect(&views, &ViewGrid::shown_changed, entry, [entry, is_shown] { entry->setChecked(is_shown()); });
    entry->setChecked(is_shown());
  };
  const auto add = [&](const QString& title, const std::function<void()>& choose,
                       const std::function<bool()>& is_shown) { add_to(*this, *group, title, choose, is_shown); };
  ViewGrid* const grid = &views;
  add(
      tr("&Four views"), [grid] { grid->set_layout(ViewLayout::Four); },
      [grid] { return grid->shown_alone() < 0 && grid->view_layout() == ViewLayout::Four; });
  addSeparator();
  const std::array<View*, 4> all = views.all();
  for (int n = 0; n < 4; ++n)
    add(
        tr("%1 large, three beside it").arg(all[static_cast<std::size_t>(n)]->objectName()),
        [grid, n] { grid->set_layout(ViewLayout::OneAndThree, n); },
        [grid, n] {
          return grid->shown_alone() < 0 && grid->view_layout() == ViewLayout::OneAndThree && grid->main_view() == n;
        });
  addSeparator();
  for (int n = 0; n < 3; ++n)
    add(
        tr("%1: previous, current and next slice").arg(all[static_cast<std::size_t>(n)]->objectName()),
        [grid, n] { grid->set_layout(ViewLayout::Neighbours, n); },
        [grid, n] {
          return grid->shown_alone() < 0 && grid->view_layout() == ViewLayout::Neighbours && grid->main_view() == n;
        });
  auto* distances = addMenu(tr("&Distance of previous and next slice"));
  auto* distance = new QActionGroup(this);
  for (const int slices : {1, 2, 3, 5, 10})
    add_to(
        *distances, *distance, counted_text(slices, "slice"), [grid, slices] { grid->set_neighbour_step(slices); },
        [grid, slices] { return grid->neighbour_step() == slices; });
  addSeparator();
  for (int n = 0; n < 4; ++n)
    add(
        tr("%1 alone").arg(all[static_cast<std::size_t>(n)]->objectName()), [grid, n] { grid->show_alone(n); },
        [grid, n] { return grid->shown_alone() == n; });
}

}  // namespace simplexseg
