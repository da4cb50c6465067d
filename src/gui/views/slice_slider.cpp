// SPDX-License-Identifier: Apache-2.0
#include "gui/views/slice_slider.h"

#include <QSignalBlocker>

#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

SliceSlider::SliceSlider(Workbench& workbench, Orientation orientation, QWidget* parent)
    : QSlider(Qt::Vertical, parent), workbench_(workbench), orientation_(orientation) {
  setAccessibleName(tr("%1 slice").arg(title_of(orientation)));
  setFixedWidth(14);
  // A click leaves the keyboard focus in the view; Tab reaches the slider.
  setFocusPolicy(Qt::TabFocus);
  connect(this, &QSlider::valueChanged, this, [this](int value) {
    if (!workbench_.has_volume()) return;
    const SliceNumber slice =
        slice_number(workbench_.session().volume().geometry(), orientation_, workbench_.view.crosshair_mm);
    const int normal = slice_axes(orientation_, Convention::Radiological).normal;
    Eigen::Vector3d at = workbench_.view.crosshair_mm;
    at[normal] += (value - slice.number) * slice.spacing_mm;
    workbench_.set_crosshair(at);
  });
  connect(&workbench_, &Workbench::view_changed, this, &SliceSlider::refresh);
  connect(&workbench_, &Workbench::volume_changed, this, &SliceSlider::refresh);
  refresh();
}

void SliceSlider::refresh() {
  const QSignalBlocker blocker(this);
  set_enabled(this, workbench_.has_volume(), tr("Open a volume first"));
  if (!workbench_.has_volume()) return;
  const SliceNumber slice =
      slice_number(workbench_.session().volume().geometry(), orientation_, workbench_.view.crosshair_mm);
  setRange(1, slice.count);
  setValue(slice.number);
  setToolTip(tr("Slice %1 of %2").arg(slice.number).arg(slice.count));
}

}  // namespace simplexseg
