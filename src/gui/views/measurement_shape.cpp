// SPDX-License-Identifier: Apache-2.0
#include "gui/views/measurement_shape.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "gui/views/slice_hits.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr double kHandleRadius = 8, kLineRadius = 4;  // largest distances of a hit, logical pixels

void add_segment(std::vector<Eigen::Vector3f>& ends, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  ends.push_back(from.cast<float>());
  ends.push_back(to.cast<float>());
}

/// Adds the arc from `centre` + a to `centre` + b, which have one length, by the smaller of the two angles between
/// them; none for legs in one line.
void add_arc(std::vector<Eigen::Vector3f>& ends, const Eigen::Vector3d& centre, const Eigen::Vector3d& a,
             const Eigen::Vector3d& b) {
  const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
  constexpr int kPieces = 24;
  Eigen::Vector3d last = a;
  for (int piece = 1; piece <= kPieces && std::sin(angle) > 1e-6; ++piece) {
    const double at = angle * piece / kPieces;
    const Eigen::Vector3d next = (std::sin(angle - at) * a + std::sin(at) * b) / std::sin(angle);
    add_segment(ends, centre + last, centre + next);
    last = next;
  }
}

void add_ellipse(std::vector<Eigen::Vector3f>& ends, const Eigen::Vector3d& centre, const Eigen::Vector3d& a,
                 const Eigen::Vector3d& b) {
  constexpr int kSides = 96;
  Eigen::Vector3d last = a;
  for (int side = 1; side <= kSides; ++side) {
    const double at = 2 * std::numbers::pi * side / kSides;
    const Eigen::Vector3d next = std::cos(at) * a + std::sin(at) * b;
    add_segment(ends, centre + last, centre + next);
    last = next;
  }
}

}  // namespace

bool lies_in_slice(const Workbench& workbench, const SliceView& view, const std::vector<Eigen::Vector3d>& points_mm) {
  if (!workbench.has_volume() || points_mm.empty()) return false;
  constexpr double kRounding = 1e-6;
  const double half_mm =
      0.5 * slice_spacing_mm(workbench.session().volume().geometry())[view.axes().normal] * (1 + kRounding);
  for (const Eigen::Vector3d& point : points_mm)
    if (view.distance_to_slice_mm(point) > half_mm) return false;
  return true;
}

std::vector<Eigen::Vector3f> lines_of(const Measurement& measurement) {
  std::vector<Eigen::Vector3f> ends;
  const std::vector<Eigen::Vector3d>& p = measurement.points_mm;
  switch (measurement.kind) {
    case MeasurementKind::Ruler:
      add_segment(ends, p[0], p[1]);
      break;
    case MeasurementKind::Angle: {
      add_segment(ends, p[1], p[0]);
      add_segment(ends, p[1], p[2]);
      const Eigen::Vector3d a = p[0] - p[1], b = p[2] - p[1];
      const double radius_mm = 0.3 * std::min(a.norm(), b.norm());
      add_arc(ends, p[1], radius_mm * a.normalized(), radius_mm * b.normalized());
      break;
    }
    case MeasurementKind::Ellipse:
      add_ellipse(ends, p[0], p[1] - p[0], p[2] - p[0]);
      break;
  }
  return ends;
}

std::vector<Eigen::Vector3d> handles_of(const Measurement& measurement) {
  std::vector<Eigen::Vector3d> handles = measurement.points_mm;
  if (measurement.kind == MeasurementKind::Ellipse)
    for (const std::size_t end : {1, 2}) handles.emplace_back(2 * handles[0] - handles[end]);
  return handles;
}

std::vector<Eigen::Vector3d> with_moved_handle(const Measurement& measurement, std::size_t handle,
                                               const Eigen::Vector3d& to_mm) {
  std::vector<Eigen::Vector3d> points = measurement.points_mm;
  if (measurement.kind != MeasurementKind::Ellipse) {
    points.at(handle) = to_mm;
    return points;
  }
  const Eigen::Vector3d centre = points[0], a = points[1] - centre, b = points[2] - centre;
  if (handle == 0) {
    for (Eigen::Vector3d& point : points) point += to_mm - centre;
    return points;
  }
  const Eigen::Vector3d normal = a.cross(b).normalized();
  Eigen::Vector3d end = to_mm - centre;
  end -= end.dot(normal) * normal;
  if (handle > 2) end = -end;
  if (handle % 2 == 1) {
    points[1] = centre + end;
    points[2] = centre + b.norm() * normal.cross(end).normalized();
  } else {
    points[2] = centre + end;
    points[1] = centre + a.norm() * end.cross(normal).normalized();
  }
  return points;
}

std::vector<Eigen::Vector3d> ellipse_in_rectangle(const Eigen::Vector3d& corner_mm, const Eigen::Vector3d& opposite_mm,
                                                  const Eigen::Vector3d& right, const Eigen::Vector3d& up) {
  const Eigen::Vector3d centre = (corner_mm + opposite_mm) / 2, half = (opposite_mm - corner_mm) / 2;
  return {centre, centre + std::abs(half.dot(right)) * right, centre + std::abs(half.dot(up)) * up};
}

std::optional<MeasurementHit> measurement_in_slice(const Workbench& workbench, const SliceView& view,
                                                   const QPointF& pixel) {
  std::optional<MeasurementHit> hit, line_hit;
  double best = kHandleRadius, best_line = kLineRadius;
  for (const Measurement& measurement : workbench.scene().measurements) {
    if (!lies_in_slice(workbench, view, measurement.points_mm)) continue;
    const std::vector<Eigen::Vector3d> handles = handles_of(measurement);
    for (std::size_t handle = 0; handle < handles.size(); ++handle) {
      const double distance = pixel_length(view.pixel_of(handles[handle]) - pixel);
      if (distance <= best) best = distance, hit = {measurement.id, handle};
    }
    const std::vector<Eigen::Vector3f> ends = lines_of(measurement);
    for (std::size_t n = 0; n + 1 < ends.size(); n += 2) {
      const double distance =
          distance_to_segment(pixel, view.pixel_of(ends[n].cast<double>()), view.pixel_of(ends[n + 1].cast<double>()));
      if (distance <= best_line) best_line = distance, line_hit = {measurement.id, std::nullopt};
    }
  }
  return hit ? hit : line_hit;
}

}  // namespace simplexseg
