// SPDX-License-Identifier: Apache-2.0
#include "gui/views/view_grid.h"

#include <QEvent>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QPainter>
#include <algorithm>
#include <utility>

#include "core/expect.h"
#include "gui/look/theme.h"
#include "gui/views/slice_slider.h"
#include "gui/views/slice_view.h"
#include "gui/views/space_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

ViewGrid::ViewGrid(Workbench& workbench, DrawnScene& drawn, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  grid_ = new QGridLayout(this);
  grid_->setContentsMargins(2, 2, 2, 2);
  grid_->setSpacing(3);
  for (const Orientation orientation : kOrientations) {
    auto* cell = new QWidget(this);
    auto* row = new QHBoxLayout(cell);
    row->setContentsMargins(0, 0, 0, 0);
    row->setSpacing(1);
    auto* slice = new SliceView(workbench, drawn, orientation, cell);
    row->addWidget(slice, 1);
    row->addWidget(new SliceSlider(workbench, orientation, cell));
    slices_[static_cast<int>(orientation)] = slice;
    cells_[static_cast<std::size_t>(orientation)] = cell;
  }
  space_ = new SpaceView(workbench, drawn, this);
  cells_[3] = space_;
  for (const std::size_t n : {0u, 1u}) {
    neighbours_[n] = new SliceView(workbench, drawn, Orientation::Axial, this, n == 0 ? -1 : 1);
    cells_[4 + n] = neighbours_[n];
  }
  const std::array<View*, 6> views = every();
  for (int n = 0; n < static_cast<int>(views.size()); ++n) {
    views[n]->setAccessibleName(tr("%1 view").arg(views[n]->objectName()));
    views[n]->installEventFilter(this);
    connect(views[n], &View::maximise_requested, this, [this, n] { show_alone(shown_alone() == n ? -1 : n); });
    if (auto* slice = qobject_cast<SliceView*>(views[n]))
      connect(slice, &SliceView::frame_changed, this, [this, slice] { link_frames(*slice); });
  }
  arrange();
}

bool ViewGrid::is_shown(int view) const {
  if (maximised_) return every()[static_cast<std::size_t>(view)] == maximised_;
  return layout_ == ViewLayout::Neighbours ? view == main_ || view > 3 : view < 4;
}

void ViewGrid::arrange() {
  const std::array<View*, 6> views = every();
  for (QWidget* cell : cells_) grid_->removeWidget(cell);
  int others = 0;
  for (int n = 0; n < static_cast<int>(views.size()); ++n) {
    cells_[n]->setVisible(is_shown(n));
    views[n]->setVisible(is_shown(n));
    if (!is_shown(n)) continue;
    if (maximised_)
      grid_->addWidget(cells_[n], 0, 0);
    else if (layout_ == ViewLayout::Four)
      grid_->addWidget(cells_[n], n / 2, n % 2);
    else if (layout_ == ViewLayout::Neighbours)
      grid_->addWidget(cells_[n], 0, n == 4 ? 0 : n == 5 ? 2 : 1);
    else if (n == main_)
      grid_->addWidget(cells_[n], 0, 0, 3, 1);
    else
      grid_->addWidget(cells_[n], others++, 1);
  }
  // Empty rows and columns take no space.
  const bool one_row = maximised_ || layout_ == ViewLayout::Neighbours;
  const int rows = one_row ? 1 : layout_ == ViewLayout::Four ? 2 : 3;
  for (int row = 0; row < 3; ++row) grid_->setRowStretch(row, row < rows);
  grid_->setColumnStretch(0, !maximised_ && layout_ == ViewLayout::OneAndThree ? 5 : 2);
  grid_->setColumnStretch(1, maximised_ ? 0 : 2);
  grid_->setColumnStretch(2, !maximised_ && layout_ == ViewLayout::Neighbours ? 2 : 0);
}

void ViewGrid::set_layout(ViewLayout layout, int main) {
  SIMPLEXSEG_EXPECT(main >= 0 && main < (layout == ViewLayout::Neighbours ? 3 : 4));
  layout_ = layout, main_ = main;
  maximised_ = nullptr;
  if (layout == ViewLayout::Neighbours)
    for (SliceView* view : neighbours_) {
      view->set_orientation(static_cast<Orientation>(main));
      view->copy_frame(slice(main));
    }
  arrange();
  emit shown_changed();
}

void ViewGrid::link_frames(SliceView& changed) {
  if (layout_ != ViewLayout::Neighbours || changed.orientation() != static_cast<Orientation>(main_)) return;
  for (SliceView* view : {&slice(main_), neighbours_[0], neighbours_[1]})
    if (view != &changed && view->orientation() == changed.orientation()) view->copy_frame(changed);
}

void ViewGrid::set_neighbour_step(int slices) {
  SIMPLEXSEG_EXPECT(slices >= 1);
  workbench_.view.neighbour_step = slices;
  workbench_.view_edited();
  emit shown_changed();
}

int ViewGrid::neighbour_step() const { return workbench_.view.neighbour_step; }

SliceView& ViewGrid::slice(int orientation) const {
  SIMPLEXSEG_EXPECT(orientation >= 0 && orientation < 3);
  return *slices_[orientation];
}

std::array<View*, 4> ViewGrid::all() const { return {slices_[0], slices_[1], slices_[2], space_}; }
std::array<View*, 6> ViewGrid::every() const {
  return {slices_[0], slices_[1], slices_[2], space_, neighbours_[0], neighbours_[1]};
}

bool ViewGrid::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::FocusIn || event->type() == QEvent::FocusOut) update();
  return QWidget::eventFilter(watched, event);
}

// Draws a frame around the view with keyboard focus, in the gap between the views, where it covers no image.
void ViewGrid::paintEvent(QPaintEvent*) {
  const std::array<View*, 6> views = every();
  for (std::size_t n = 0; n < views.size(); ++n) {
    if (!views[n]->hasFocus()) continue;
    QPainter painter(this);
    const QRect cell = cells_[n]->geometry(), frame = cell.adjusted(-2, -2, 2, 2);
    painter.setClipRegion(QRegion(frame) - cell);  // the cell outside its view is transparent
    painter.fillRect(frame, theme::shades().accent);
  }
}

void ViewGrid::fit() {
  for (View* view : every()) view->fit();
}

void ViewGrid::centre_on_crosshair() {
  for (View* view : every()) view->centre_on_crosshair();
}

int ViewGrid::shown_alone() const {
  const std::array<View*, 6> views = every();
  return maximised_ ? static_cast<int>(std::find(views.begin(), views.end(), maximised_) - views.begin()) : -1;
}

void ViewGrid::show_alone(int view) {
  SIMPLEXSEG_EXPECT(view >= -1 && view < 6);
  const std::array<View*, 6> views = every();
  View* const before = std::exchange(maximised_, view < 0 ? nullptr : views[static_cast<std::size_t>(view)]);
  if (maximised_ == before) return;
  arrange();
  emit shown_changed();
}

}  // namespace simplexseg
