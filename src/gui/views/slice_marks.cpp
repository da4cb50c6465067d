// SPDX-License-Identifier: Apache-2.0
// Points, strokes and lassos in a slice view.
#include <cmath>
#include <vector>

#include "gui/look/point_style.h"
#include "gui/look/theme.h"
#include "gui/views/slice_hits.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

// Draws the sections of the balls of inside and outside points.
void SliceView::draw_marks(const Projection& projection) {
  for (const UserPoint& point : workbench_.scene().points) {
    const MeshItem* item = workbench_.scene().find_mesh(point.mesh);
    const double off = distance_to_slice_mm(point.position_mm);
    if (!item || point.is_paint() || point.kind == MarkKind::Boundary || off >= point.radius_mm) continue;
    const double radius_mm = std::sqrt(point.radius_mm * point.radius_mm - off * off);
    draw_circle(projection, point.position_mm, radius_mm, rgba_of(item->colour, 0.8f), 1.2f);
  }
}

void SliceView::draw_stroke(const Projection& projection, const UserPoint& stroke) {
  const MeshItem* item = workbench_.scene().find_mesh(stroke.mesh);
  const std::vector<Eigen::Vector3f> ends = lines_in_slice(workbench_, *this, stroke);
  if (ends.empty()) return;
  const bool starts_mesh = stroke.mesh == 0;
  if (!item && !starts_mesh) return;
  const bool marked =
      stroke.id != 0 && (stroke.id == workbench_.view.selected_point || stroke.id == workbench_.view.hovered_point);
  const auto ratio = static_cast<float>(devicePixelRatio());
  const float core = stroke.is_lasso() ? 1.6f : 3.0f, rim = stroke.is_lasso() ? (marked ? 4.4f : 2.8f) : 5.0f;
  if (!starts_mesh)
    line_painter_.draw(projection, ends, marked ? rgba_of(theme::kSelected) : Rgba(1, 1, 1, 0.8f), rim * ratio);
  line_painter_.draw(projection, ends, rgba_of(starts_mesh ? theme::kSelected : colour_of(stroke.kind, item->colour)),
                     core * ratio);
}

void SliceView::draw_points(const Projection& projection) {
  draw_marks(projection);
  for (const UserPoint& point : workbench_.scene().points)
    if (!point.is_paint()) draw_stroke(projection, point);
  if (const std::optional<UserPoint>& stroke = tools_.stroke(); stroke && !stroke->is_paint())
    draw_stroke(projection, *stroke);
  std::vector<DiscPainter::Disc> discs;
  const float ratio = static_cast<float>(devicePixelRatio());
  for (const UserPoint& point : workbench_.scene().points) {
    const MeshItem* item = workbench_.scene().find_mesh(point.mesh);
    const auto opacity = static_cast<float>(handle_opacity(distance_to_slice_mm(point.position_mm)));
    if (!item || opacity <= 0 || point.is_paint()) continue;
    const bool selected = point.id == workbench_.view.selected_point,
               hovered = point.id == workbench_.view.hovered_point;
    const Rgba rim = selected ? rgba_of(theme::kSelected, opacity) : Rgba(1, 1, 1, opacity);
    discs.push_back({point.position_mm.cast<float>(), rgba_of(colour_of(point.kind, item->colour), opacity), rim,
                     (hovered ? 8.0f : 6.5f) * ratio, glyph_of(point.kind)});
  }
  disc_painter_.draw(projection, discs);
}

}  // namespace simplexseg
