// SPDX-License-Identifier: Apache-2.0
// Paint and brush in a slice view.
#include "core/number_text.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"
#include "session/paint.h"

namespace simplexseg {

void SliceView::draw_paint(const Projection& projection) {
  const auto draw = [&](const PaintOutline& outline, float width) {
    const float width_px = width * static_cast<float>(devicePixelRatio());
    if (!outline.painted.empty()) line_painter_.draw(projection, outline.painted, rgba_of(theme::kInside), width_px);
    if (!outline.erased.empty()) line_painter_.draw(projection, outline.erased, rgba_of(theme::kOutside), width_px);
    if (!outline.frozen.empty()) line_painter_.draw(projection, outline.frozen, rgba_of(theme::kFrozen), width_px);
  };
  const VolumeGeometry& geometry = workbench_.session().volume().geometry();
  const SliceGrid grid = slice_grid(geometry, orientation_, through_mm());
  const double spacing_mm = slice_spacing_mm(geometry)[axes().normal];
  if (workbench_.view.show_meshes) draw(paint_layer_.in_slice(workbench_.scene(), grid, spacing_mm), 1.2f);
  const std::optional<UserPoint>& stroke = tools_.stroke();
  if (!stroke || !stroke->is_paint()) return;
  const PaintStroke drawn[] = {paint_stroke_of(*stroke)};
  draw(stroke->edit == VoxelEdit::Freeze ? outline_of({}, drawn, grid, spacing_mm)
                                         : outline_of(drawn, {}, grid, spacing_mm),
       2);
  if (drawn[0].brush.shape != PaintBrush::Shape::Contour || drawn[0].vertices_mm.size() < 2) return;
  std::vector<Eigen::Vector3f> path;
  for (std::size_t n = 1; n < drawn[0].vertices_mm.size(); ++n)
    for (const std::size_t end : {n - 1, n}) path.push_back(drawn[0].vertices_mm[end].cast<float>());
  line_painter_.draw(projection, path, rgba_of(theme::kSelected), 1.6f * static_cast<float>(devicePixelRatio()));
}

void SliceView::draw_brush(const Projection& projection) {
  const std::optional<Eigen::Vector3d> centre_mm = tools_.brush_centre_mm();
  const ViewState& view = workbench_.view;
  if (!centre_mm || view.lasso) return;
  const QColor& colour = view.tool == Tool::Brush    ? theme::kInside
                         : view.tool == Tool::Eraser ? theme::kOutside
                                                     : theme::kFrozen;
  draw_circle(projection, *centre_mm, view.brush_mm, rgba_of(colour), 1.6f);
}

QString SliceView::brush_text() const {
  const ViewState& view = workbench_.view;
  QString what;
  if (view.lasso)
    what = view.brush_3d ? tr("lasso through the volume") : tr("lasso");
  else
    what = (view.brush_3d ? tr("ball, radius %1") : tr("disc, radius %1")).arg(text(length_text(view.brush_mm)));
  return view.smart_brush && view.tool != Tool::Freeze ? tr("%1, stops at edges").arg(what) : what;
}

}  // namespace simplexseg
