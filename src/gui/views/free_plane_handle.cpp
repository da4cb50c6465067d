// SPDX-License-Identifier: Apache-2.0
#include "gui/views/free_plane_handle.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "gui/look/theme.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr double kRadiusPixels = 56;  // of the ring, and length of the arrow; logical pixels
constexpr double kReachPixels = 9;
}  // namespace

bool FreePlaneHandle::is_shown() const {
  const ViewState& view = workbench_.view;
  return workbench_.has_volume() && view.show_annotations && view.clip.on[static_cast<std::size_t>(CutPlane::Free)];
}

FreePlaneHandle::Shape FreePlaneHandle::shape(const ScreenMap& map) const {
  const ClipState& clip = workbench_.view.clip;
  Shape shape;
  shape.centre_mm = clip.free_point_mm;
  shape.normal =
      clip.flipped[static_cast<std::size_t>(CutPlane::Free)] ? Eigen::Vector3d(-clip.free_normal) : clip.free_normal;
  const Eigen::Vector3d in_plane = u_ - shape.normal * shape.normal.dot(u_);
  shape.u = in_plane.norm() > 0.1 ? in_plane.normalized() : shape.normal.unitOrthogonal();
  shape.v = shape.normal.cross(shape.u);
  shape.radius_mm = kRadiusPixels * map.mm_per_pixel(shape.centre_mm);
  shape.tip_mm = shape.centre_mm + shape.radius_mm * shape.normal;
  shape.rim_mm = {shape.centre_mm + shape.radius_mm * shape.u, shape.centre_mm + shape.radius_mm * shape.v,
                  shape.centre_mm - shape.radius_mm * shape.u, shape.centre_mm - shape.radius_mm * shape.v};
  return shape;
}

void FreePlaneHandle::draw(const Projection& projection, const ScreenMap& map, double pixel_ratio, LinePainter& lines,
                           DiscPainter& discs) {
  if (!is_shown()) return;
  const Shape handle = shape(map);
  const auto ratio = static_cast<float>(pixel_ratio);
  draw_border(projection, handle, 1.2f * ratio, lines);
  constexpr int kSides = 64;
  std::vector<Eigen::Vector3f> ring;
  const auto at = [&](int side) -> Eigen::Vector3f {
    const double angle = 2 * std::numbers::pi * side / kSides;
    return (handle.centre_mm + handle.radius_mm * (std::cos(angle) * handle.u + std::sin(angle) * handle.v))
        .cast<float>();
  };
  for (int side = 0; side < kSides; ++side) {
    ring.push_back(at(side));
    ring.push_back(at(side + 1));
  }
  const Eigen::Vector3f arrow[] = {handle.centre_mm.cast<float>(), handle.tip_mm.cast<float>()};
  const Part active = is_dragged() ? dragged_ : hovered_;
  const auto colour = [&](Part part) { return part == active ? rgba_of(theme::kSelected) : rgba_of(theme::kText); };
  set_depth(Depth::Ignore);
  lines.draw(projection, ring, colour(Part::Tilt), (active == Part::Tilt ? 2.4f : 1.6f) * ratio);
  lines.draw(projection, arrow, colour(Part::Move), (active == Part::Move ? 3.0f : 2.0f) * ratio);
  std::vector<DiscPainter::Disc> ends;
  const Rgba rim(1, 1, 1, 1);
  for (const Eigen::Vector3d& place : handle.rim_mm)
    ends.push_back({place.cast<float>(), colour(Part::Tilt), rim, 4.5f * ratio});
  ends.push_back({handle.centre_mm.cast<float>(), colour(Part::Move), rim, 4.5f * ratio});
  ends.push_back({handle.tip_mm.cast<float>(), colour(Part::Move), rim, 6.5f * ratio});
  discs.draw(projection, ends);
  set_depth(Depth::Test);
}

// Polygon in which the plane cuts the bounding box of the volume.
void FreePlaneHandle::draw_border(const Projection& projection, const Shape& shape, float width_px,
                                  LinePainter& lines) const {
  const WorldBox box = world_box(workbench_.session().volume().geometry());
  const auto corner = [&](int n) -> Eigen::Vector3d {
    return {(n & 1) != 0 ? box.high_mm.x() : box.low_mm.x(), (n & 2) != 0 ? box.high_mm.y() : box.low_mm.y(),
            (n & 4) != 0 ? box.high_mm.z() : box.low_mm.z()};
  };
  std::vector<Eigen::Vector3d> corners;
  for (int a = 0; a < 8; ++a)
    for (const int axis : {1, 2, 4}) {
      if ((a & axis) != 0) continue;
      const Eigen::Vector3d from = corner(a), to = corner(a | axis);
      const double at_from = shape.normal.dot(from - shape.centre_mm), at_to = shape.normal.dot(to - shape.centre_mm);
      if ((at_from > 0) != (at_to > 0)) corners.push_back(from + (to - from) * (at_from / (at_from - at_to)));
    }
  if (corners.size() < 3) return;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& at : corners) middle += at / static_cast<double>(corners.size());
  const auto angle = [&](const Eigen::Vector3d& at) {
    return std::atan2(shape.v.dot(at - middle), shape.u.dot(at - middle));
  };
  std::sort(corners.begin(), corners.end(),
            [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return angle(a) < angle(b); });
  std::vector<Eigen::Vector3f> border;
  for (std::size_t n = 0; n < corners.size(); ++n) {
    border.push_back(corners[n].cast<float>());
    border.push_back(corners[(n + 1) % corners.size()].cast<float>());
  }
  lines.draw(projection, border, rgba_of(theme::kText, 0.8f), width_px);
}

FreePlaneHandle::Part FreePlaneHandle::part_at(const ScreenMap& map, const QPointF& pixel) const {
  if (!is_shown()) return Part::None;
  const Shape handle = shape(map);
  double nearest = kReachPixels;
  Part part = Part::None;
  const auto test = [&](const Eigen::Vector3d& world_mm, Part candidate) {
    const std::optional<QPointF> at = map.pixel(world_mm);
    const double distance = at ? std::hypot(at->x() - pixel.x(), at->y() - pixel.y()) : kReachPixels + 1;
    if (distance <= nearest) nearest = distance, part = candidate;
  };
  for (const Eigen::Vector3d& place : handle.rim_mm) test(place, Part::Tilt);
  test(handle.centre_mm, Part::Move);
  test(handle.tip_mm, Part::Move);
  return part;
}

bool FreePlaneHandle::hover(const ScreenMap& map, const QPointF& pixel) {
  const Part before = hovered_;
  hovered_ = part_at(map, pixel);
  return hovered_ != before;
}

bool FreePlaneHandle::press(const ScreenMap& map, const QPointF& pixel) {
  dragged_ = part_at(map, pixel);
  if (dragged_ == Part::None) return false;
  last_ = pixel;
  if (dragged_ == Part::Tilt) {
    const Shape handle = shape(map);
    u_ = handle.u;
    double nearest = INFINITY;
    for (const Eigen::Vector3d& place : handle.rim_mm) {
      const std::optional<QPointF> at = map.pixel(place);
      const double distance = at ? std::hypot(at->x() - pixel.x(), at->y() - pixel.y()) : INFINITY;
      if (distance < nearest) nearest = distance, rim_ = (place - handle.centre_mm).normalized();
    }
  }
  return true;
}

void FreePlaneHandle::move(double mm) {
  ClipState& clip = workbench_.view.clip;
  clip.free_point_mm += mm * clip.free_normal;
  workbench_.view_edited();
}

void FreePlaneHandle::drag(const ScreenMap& map, const QPointF& pixel) {
  if (dragged_ == Part::Tilt) {
    tilt(map, pixel);
    return;
  }
  const QPointF moved = pixel - last_;
  last_ = pixel;
  // Motion of the plane along its normal that follows the mouse on the screen. If the normal points at the viewer,
  // upwards is away from the viewer.
  const ClipState& clip = workbench_.view.clip;
  const double mm_per_pixel = map.mm_per_pixel(clip.free_point_mm);
  const Eigen::Vector2d on_screen(map.axis(0).dot(clip.free_normal), -map.axis(1).dot(clip.free_normal));
  constexpr double kForeshortened = 0.3;
  if (on_screen.norm() > kForeshortened) {
    move(mm_per_pixel * on_screen.dot(Eigen::Vector2d(moved.x(), moved.y())) / on_screen.squaredNorm());
  } else {
    const double towards_viewer = map.axis(2).dot(clip.free_normal) > 0 ? 1 : -1;
    move(mm_per_pixel * moved.y() * towards_viewer);
  }
}

// The disc follows the mouse on the sphere of the ring, as with an arcball (Shoemake, ARCBALL, 1992).
void FreePlaneHandle::tilt(const ScreenMap& map, const QPointF& pixel) {
  ClipState& clip = workbench_.view.clip;
  const OrbitCamera::Ray ray = map.ray(pixel);
  const double radius_mm = kRadiusPixels * map.mm_per_pixel(clip.free_point_mm);
  const double along = (clip.free_point_mm - ray.origin_mm).dot(ray.direction);
  const Eigen::Vector3d beside = ray.origin_mm + along * ray.direction - clip.free_point_mm;
  const double half_chord = std::sqrt(std::max(radius_mm * radius_mm - beside.squaredNorm(), 0.0));
  // The side of the sphere on which the disc is.
  const double side = map.axis(2).dot(rim_) >= -1e-6 ? -1 : 1;
  const Eigen::Vector3d to = beside + side * half_chord * ray.direction;
  if (to.norm() < 1e-9) return;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(rim_, to.normalized());
  rim_ = to.normalized();
  u_ = turn * u_;
  clip.free_normal = (turn * clip.free_normal).normalized();
  workbench_.view_edited();
}

void FreePlaneHandle::face_camera(const ScreenMap& map) {
  ClipState& clip = workbench_.view.clip;
  clip.free_point_mm = workbench_.view.crosshair_mm;
  clip.free_normal = map.axis(2).normalized();
  clip.flipped[static_cast<std::size_t>(CutPlane::Free)] = false;
  clip.free_placed = true;
  u_ = map.axis(0);
  workbench_.view_edited();
}

}  // namespace simplexseg
