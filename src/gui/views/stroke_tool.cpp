// SPDX-License-Identifier: Apache-2.0
#include "gui/views/stroke_tool.h"

#include <utility>

#include "gui/workbench/workbench.h"

namespace simplexseg {

void StrokeTool::begin(MarkKind kind, const Eigen::Vector3d& at_mm) {
  stroke_ = UserPoint{0, workbench_.view.active_mesh, at_mm, kind};
}

void StrokeTool::extend(const Eigen::Vector3d& at_mm) {
  const VolumeGeometry& geometry = workbench_.session().volume().geometry();
  if (!stroke_ || !geometry.contains(at_mm)) return;
  const Eigen::Vector3d last = stroke_->is_stroke() ? stroke_->path_mm.back() : Eigen::Vector3d(0, 0, 0);
  const Eigen::Vector3d offset = at_mm - stroke_->position_mm;
  if ((offset - last).norm() >= 0.5 * geometry.spacing_mm.minCoeff()) stroke_->path_mm.push_back(offset);
}

void StrokeTool::finish() {
  const std::optional<UserPoint> stroke = std::exchange(stroke_, std::nullopt);
  if (!stroke) return;
  workbench_.apply(AddPoint{stroke->mesh, stroke->position_mm, stroke->kind, 0, {0, 0, 0}, stroke->path_mm});
}

}  // namespace simplexseg
