// SPDX-License-Identifier: Apache-2.0
#include "gui/views/slice_hits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gui/views/picking.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr double kHitRadius = 8;  // largest distance of a hit on a handle, stroke or contour, logical pixels

/// Distance from a position to a point's handle or stroke, logical pixels; infinite if they are not visible.
double distance_to(const Workbench& workbench, const SliceView& view, const UserPoint& point, const QPointF& pixel) {
  double nearest = handle_opacity(view.distance_to_slice_mm(point.position_mm)) > 0
                       ? pixel_length(view.pixel_of(point.position_mm) - pixel)
                       : std::numeric_limits<double>::infinity();
  const std::vector<Eigen::Vector3f> lines = lines_in_slice(workbench, view, point);
  for (std::size_t n = 0; n + 1 < lines.size(); n += 2)
    nearest = std::min(nearest, distance_to_segment(pixel, view.pixel_of(lines[n].cast<double>()),
                                                    view.pixel_of(lines[n + 1].cast<double>())));
  return nearest;
}

}  // namespace

double pixel_length(const QPointF& offset) { return std::hypot(offset.x(), offset.y()); }

double distance_to_segment(const QPointF& p, const QPointF& a, const QPointF& b) {
  const QPointF along = b - a, to = p - a;
  const double squared = QPointF::dotProduct(along, along);
  const double t = squared > 0 ? std::clamp(QPointF::dotProduct(to, along) / squared, 0.0, 1.0) : 0;
  return pixel_length(p - (a + t * along));
}

ItemId point_in_slice(const Workbench& workbench, const SliceView& view, const QPointF& pixel) {
  ItemId nearest = 0;
  double best = kHitRadius;
  if (paints(workbench.view.tool)) return 0;
  for (const UserPoint& point : workbench.scene().points) {
    if (point.is_paint()) continue;
    const double distance = distance_to(workbench, view, point, pixel);
    if (distance <= best) {
      best = distance;
      nearest = point.id;
    }
  }
  return nearest;
}

ItemId mesh_in_slice(Workbench& workbench, const SliceView& view, const QPointF& pixel) {
  ItemId nearest = 0, containing = 0;
  double best = kHitRadius;
  // Reads poses back from the engine, which is too slow for each mouse move.
  for (const Surface& surface : visible_surfaces(workbench.session().scene())) {
    const std::vector<Eigen::Vector3f> ends_mm =
        cut_surface(surface.shape, view.axes().normal, static_cast<float>(view.slice_mm()));
    bool inside = false;
    for (std::size_t n = 0; n + 1 < ends_mm.size(); n += 2) {
      const QPointF a = view.pixel_of(ends_mm[n].cast<double>()), b = view.pixel_of(ends_mm[n + 1].cast<double>());
      const double distance = distance_to_segment(pixel, a, b);
      if (distance <= best) {
        best = distance;
        nearest = surface.mesh;
      }
      // A ray to the right crosses a closed contour an odd number of times if the position is inside.
      if ((a.y() > pixel.y()) != (b.y() > pixel.y()) &&
          pixel.x() < a.x() + (pixel.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
        inside = !inside;
      }
    }
    if (inside) containing = surface.mesh;
  }
  return nearest ? nearest : containing;
}

std::vector<Eigen::Vector3f> lines_in_slice(const Workbench& workbench, const SliceView& view, const UserPoint& point) {
  std::vector<Eigen::Vector3f> ends;
  if (!point.is_stroke()) return ends;
  // In a slice across it, nothing but two places would be visible.
  if (point.is_lasso() && std::abs(point.lasso_normal[view.axes().normal]) < 0.9) return ends;
  const std::vector<Eigen::Vector3d> vertices = point.vertices_mm();
  const double near_mm = std::max(point.radius_mm, 0.5 * workbench.session().volume().geometry().spacing_mm.maxCoeff());
  for (std::size_t p = 1; p < vertices.size(); ++p) {
    if (std::min(view.distance_to_slice_mm(vertices[p - 1]), view.distance_to_slice_mm(vertices[p])) > near_mm)
      continue;
    ends.push_back(vertices[p - 1].cast<float>());
    ends.push_back(vertices[p].cast<float>());
  }
  if (point.is_lasso() && point.id != 0 && !ends.empty()) {  // closed, unless it is being drawn
    ends.push_back(vertices.back().cast<float>());
    ends.push_back(vertices.front().cast<float>());
  }
  return ends;
}

}  // namespace simplexseg
