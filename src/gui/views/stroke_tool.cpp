// SPDX-License-Identifier: Apache-2.0
#include "gui/views/stroke_tool.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

void StrokeTool::begin(MarkKind kind, const Eigen::Vector3d& at_mm, const Eigen::Vector3d& normal) {
  stroke_ = UserPoint{0, workbench_.view.active_mesh, at_mm, kind};
  if (workbench_.view.lasso) stroke_->lasso_normal = normal;
}

void StrokeTool::begin_start(const Eigen::Vector3d& at_mm, const Eigen::Vector3d& normal) {
  stroke_ = UserPoint{0, 0, at_mm, MarkKind::Inside};
  stroke_->lasso_normal = normal;
}

void StrokeTool::begin_paint(const Eigen::Vector3d& at_mm, const Eigen::Vector3d& normal) {
  const ViewState& view = workbench_.view;
  begin(view.tool == Tool::Eraser ? MarkKind::Outside : MarkKind::Inside, at_mm, normal);
  stroke_->lasso_normal.setZero();
  stroke_->edit = view.tool == Tool::Freeze ? VoxelEdit::Freeze
                  : view.smart_brush        ? VoxelEdit::SmartPaint
                                            : VoxelEdit::None;
  // The extent of a voxel along the normal: in a volume that is not axis-aligned, a disc then has no gaps.
  const VolumeGeometry& geometry = workbench_.session().volume().geometry();
  const double thickness_mm = (geometry.world_from_index().linear().transpose() * normal).cwiseAbs().sum();
  if (view.lasso) {
    stroke_->brush = PaintBrush::contour(normal, view.brush_3d ? 0 : thickness_mm);
    return;
  }
  stroke_->radius_mm = view.brush_mm;
  stroke_->brush = view.brush_3d ? PaintBrush::ball() : PaintBrush::disc(normal, thickness_mm);
}

void StrokeTool::resize_brush(double notches) {
  constexpr double kStep = 1.15, kMostMm = 60;
  const double least_mm = 0.5 * workbench_.session().volume().geometry().spacing_mm.minCoeff();
  workbench_.view.brush_mm = std::clamp(workbench_.view.brush_mm * std::pow(kStep, notches), least_mm, kMostMm);
  workbench_.view_edited();
}

void StrokeTool::extend(const Eigen::Vector3d& at_mm) {
  const VolumeGeometry& geometry = workbench_.session().volume().geometry();
  if (!stroke_ || !geometry.contains(at_mm)) return;
  const Eigen::Vector3d last = stroke_->is_stroke() ? stroke_->path_mm.back() : Eigen::Vector3d(0, 0, 0);
  Eigen::Vector3d offset = at_mm - stroke_->position_mm;
  // A contour stays in the slice in which it began, also if the slice changes meanwhile.
  const Eigen::Vector3d normal =
      stroke_->brush.shape == PaintBrush::Shape::Contour ? stroke_->brush.normal : stroke_->lasso_normal;
  offset -= normal.dot(offset) * normal;
  // The vertices of a large brush may be farther apart: its stroke hardly differs.
  const double least_mm = std::max(0.5 * geometry.spacing_mm.minCoeff(), 0.1 * stroke_->radius_mm);
  if ((offset - last).norm() >= least_mm) stroke_->path_mm.push_back(offset);
}

bool StrokeTool::finish() {
  const std::optional<UserPoint> stroke = std::exchange(stroke_, std::nullopt);
  if (!stroke) return false;
  if (stroke->mesh == 0) return start(*stroke);
  if (stroke->brush.shape == PaintBrush::Shape::Contour && stroke->path_mm.size() < 2) {
    workbench_.notify(Severity::Note, SliceView::tr("Lasso: drag around the part"));
    return false;
  }
  if (stroke->is_lasso() && stroke->is_stroke()) {
    workbench_.apply(
        AddLasso{stroke->mesh, stroke->kind, stroke->vertices_mm(), stroke->lasso_normal, workbench_.view.local_marks});
    return false;
  }
  workbench_.apply(AddPoint{stroke->mesh,
                            stroke->position_mm,
                            stroke->kind,
                            stroke->radius_mm,
                            {0, 0, 0},
                            stroke->path_mm,
                            stroke->brush,
                            stroke->edit,
                            workbench_.view.local_marks});
  return false;
}

bool StrokeTool::start(const UserPoint& contour) {
  if (contour.path_mm.size() < 2) {
    workbench_.notify(Severity::Note, SliceView::tr("New segmentation: drag around the structure"));
    return false;
  }
  AddMesh command;
  command.like = workbench_.view.active_mesh;
  command.contour_mm = contour.vertices_mm();
  command.contour_normal = contour.lasso_normal;
  return workbench_.apply(command);
}

}  // namespace simplexseg
