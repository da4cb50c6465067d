// SPDX-License-Identifier: Apache-2.0
// Rectangles that are dragged in slices: the box from which a segmentation starts, and tissue whose intensities are
// sampled.
#include <cmath>

#include "gui/views/slice_tools.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

std::vector<Eigen::Vector3d> SliceTools::box_mm() const {
  if (drag_ != Drag::Box || !moved_) return {};
  const QPointF across(last_.x(), press_.y()), down(press_.x(), last_.y());
  return {view_.world_of(press_), view_.world_of(across), view_.world_of(last_), view_.world_of(down)};
}

void SliceTools::finish_box() {
  const std::vector<Eigen::Vector3d> corners = box_mm();
  drag_ = Drag::None;
  constexpr double kLeast = 6;  // shortest side, logical pixels
  if (corners.empty() || std::abs(last_.x() - press_.x()) < kLeast || std::abs(last_.y() - press_.y()) < kLeast) {
    workbench_.notify(Severity::Note, samples_range_
                                          ? SliceView::tr("Range of intensities: drag a rectangle over the tissue")
                                          : SliceView::tr("New segmentation: drag a box around the structure"));
    return;
  }
  if (samples_range_) {
    if (!workbench_.sample_range({corners[0], corners[1], corners[2]})) return;
    workbench_.view.tool = Tool::Crosshair;
    workbench_.view_edited();
    return;
  }
  AddMesh command;
  command.like = workbench_.view.active_mesh;
  command.box_mm = corners;
  if (workbench_.apply(command)) end_start();
}

}  // namespace simplexseg
