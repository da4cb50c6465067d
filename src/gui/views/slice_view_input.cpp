// SPDX-License-Identifier: Apache-2.0
// What mouse and keys do in a slice; what they mean is looked up in the table of bindings.
#include <QKeyEvent>
#include <QMenu>
#include <QMouseEvent>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

#include "gui/views/slice_view.h"
#include "gui/views/surfaces.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr double kHitRadius = 8;   // logical pixels
constexpr double kDragStarts = 3;  // logical pixels: less is a click

double length(const QPointF& offset) { return std::hypot(offset.x(), offset.y()); }

double distance_to_segment(const QPointF& p, const QPointF& a, const QPointF& b) {
  const QPointF along = b - a, to = p - a;
  const double squared = QPointF::dotProduct(along, along);
  const double t = squared > 0 ? std::clamp(QPointF::dotProduct(to, along) / squared, 0.0, 1.0) : 0;
  return length(p - (a + t * along));
}

}  // namespace

ItemId SliceView::point_at(const QPointF& pixel) const {
  ItemId nearest = 0;
  double best = kHitRadius;
  for (const AttractionPoint& point : workbench_.scene().points) {
    if (handle_opacity(distance_to_slice_mm(point.position_mm)) <= 0) continue;
    const double distance = length(pixel_of(point.position_mm) - pixel);
    if (distance <= best) {
      best = distance;
      nearest = point.id;
    }
  }
  return nearest;
}

ItemId SliceView::mesh_at(const QPointF& pixel) const {
  ItemId nearest = 0, around = 0;
  double best = kHitRadius;
  // Reads the poses back: for a click, never for each move of the mouse.
  for (const Surface& surface : visible_surfaces(workbench_.session().scene())) {
    const std::vector<Eigen::Vector3f> ends_mm =
        cut_surface(surface.shape, axes().normal, static_cast<float>(slice_mm()));
    bool inside = false;
    for (std::size_t n = 0; n + 1 < ends_mm.size(); n += 2) {
      const QPointF a = pixel_of(ends_mm[n].cast<double>()), b = pixel_of(ends_mm[n + 1].cast<double>());
      const double distance = distance_to_segment(pixel, a, b);
      if (distance <= best) {
        best = distance;
        nearest = surface.mesh;
      }
      // Crossings of a ray to the right: odd inside a closed outline.
      if ((a.y() > pixel.y()) != (b.y() > pixel.y()) &&
          pixel.x() < a.x() + (pixel.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
        inside = !inside;
      }
    }
    if (inside) around = surface.mesh;
  }
  return nearest ? nearest : around;
}

void SliceView::begin_left_drag(const QPointF& pixel, Qt::KeyboardModifiers modifiers) {
  ViewState& view = workbench_.view;
  if (view.window_level_armed) {
    drag_ = Drag::WindowLevel;
    return;
  }
  const std::optional<Act> act = gesture(Where::Slices, Mouse::Left, modifiers);
  if (!act) return;
  const ItemId under = point_at(pixel);
  switch (*act) {
    case Act::AddPoint:
      begin_point(pixel);
      return;
    case Act::ErasePoint:
      if (under) workbench_.apply(DeleteAttractionPoint{under});
      return;
    case Act::PickMesh:
      workbench_.set_active_mesh(mesh_at(pixel));
      return;
    default:
      break;
  }
  if (view.tool == Tool::ZoomPan) {
    drag_ = Drag::Pan;
  } else if (view.tool == Tool::Seed) {
    drag_ = Drag::Seed;
    seed_centre_mm_ = world_of(pixel);
    seed_radius_mm_ = 0;
  } else if (under) {
    drag_ = Drag::Point;
    dragged_point_ = under;
    drag_continues_ = false;
    // The handle keeps its distance from the slice and from the mouse.
    grab_offset_mm_ = workbench_.scene().find_point(under)->position_mm - world_of(pixel);
    view.selected_point = under;
    workbench_.view_edited();
  } else if (view.tool == Tool::Point) {
    begin_point(pixel);
  } else {
    drag_ = Drag::Crosshair;
    workbench_.set_crosshair(world_of(pixel));
  }
}

void SliceView::begin_point(const QPointF& pixel) {
  if (!workbench_.active_mesh()) {
    workbench_.say(Severity::Warning, tr("No mesh to attract: add one with tool 4 or in the panel Meshes"));
    return;
  }
  ItemId point = 0;
  if (!workbench_.apply(AddAttractionPoint{workbench_.view.active_mesh, world_of(pixel)}, &point)) return;
  drag_ = Drag::Point;
  dragged_point_ = point;
  drag_continues_ = true;
  grab_offset_mm_.setZero();
}

void SliceView::drag_point(const QPointF& pixel) {
  if (!workbench_.scene().find_point(dragged_point_)) {
    drag_ = Drag::None;
    return;
  }
  if (workbench_.apply(MoveAttractionPoint{dragged_point_, world_of(pixel) + grab_offset_mm_, drag_continues_})) {
    drag_continues_ = true;
  }
}

void SliceView::drag_window_level(const QPointF& moved) {
  ViewState& view = workbench_.view;
  // The whole height of a view is about twice the window.
  const double intensity_per_pixel = std::max(view.window, 1e-9) / 250;
  view.window = std::max(view.window + moved.x() * intensity_per_pixel, 1e-9);
  view.level += moved.y() * intensity_per_pixel;
  workbench_.view_edited();
}

void SliceView::finish_seed() {
  if (seed_radius_mm_ < 2 * mm_per_pixel_) {
    workbench_.say(Severity::Note, tr("New mesh: press at the centre, drag to the radius, release"));
    return;
  }
  workbench_.apply(AddMesh{{}, Seed{seed_centre_mm_, seed_radius_mm_}, std::nullopt, workbench_.view.active_mesh});
}

void SliceView::hover(const QPointF& pixel) {
  const ItemId under = point_at(pixel);
  if (under == workbench_.view.hovered_point) return;
  workbench_.view.hovered_point = under;
  workbench_.view_edited();
}

void SliceView::zoom_about(const QPointF& pixel, double factor) {
  const WorldBox box = world_box(workbench_.session().volume().geometry());
  const Eigen::Vector3d before = world_of(pixel);
  const double coarsest = 4 * box.extent_mm().maxCoeff() / std::max(std::min(width(), height()), 1);
  mm_per_pixel_ = std::clamp(mm_per_pixel_ * factor, 1e-4 * coarsest, coarsest);
  centre_mm_ += before - world_of(pixel);
  fitted_ = false;
  update();
}

void SliceView::step_slice(int slices) {
  if (!workbench_.has_volume()) return;
  const int normal = axes().normal;
  Eigen::Vector3d at = workbench_.view.crosshair_mm;
  at[normal] += slices * slice_spacing_mm(workbench_.session().volume().geometry())[normal];
  workbench_.set_crosshair(at);
}

void SliceView::mousePressEvent(QMouseEvent* event) {
  if (!workbench_.has_volume() || drag_ != Drag::None) return;
  press_ = last_ = event->position();
  moved_ = false;
  if (event->button() == Qt::LeftButton) {
    begin_left_drag(event->position(), event->modifiers());
    return;
  }
  const Mouse mouse = event->button() == Qt::RightButton ? Mouse::Right : Mouse::Middle;
  const std::optional<Act> act = gesture(Where::Slices, mouse, {});
  if (act == Act::Zoom) drag_ = Drag::Zoom;
  if (act == Act::Pan) drag_ = Drag::Pan;
}

void SliceView::mouseMoveEvent(QMouseEvent* event) {
  if (!workbench_.has_volume()) return;
  const QPointF here = event->position(), moved = here - last_;
  last_ = here;
  moved_ |= length(here - press_) >= kDragStarts;
  switch (drag_) {
    case Drag::None:
      hover(here);
      if (event->buttons() == Qt::NoButton &&
          gesture(Where::Slices, Mouse::Move, event->modifiers()) == Act::FollowMouse) {
        workbench_.set_crosshair(world_of(here));
      }
      break;
    case Drag::Crosshair:
      workbench_.set_crosshair(world_of(here));
      break;
    case Drag::Point:
      // A click on a handle selects it and does not shift it by the tremble of a hand.
      if (moved_ || drag_continues_) drag_point(here);
      break;
    case Drag::Zoom:
      if (moved_) zoom_about(press_, std::exp(moved.y() * 0.01));
      break;
    case Drag::Pan:
      centre_mm_ += (moved.y() * axes().up - moved.x() * axes().right) * mm_per_pixel_;
      fitted_ = false;
      update();
      break;
    case Drag::WindowLevel:
      drag_window_level(moved);
      break;
    case Drag::Seed:
      seed_radius_mm_ = (world_of(here) - seed_centre_mm_).norm();
      update();
      break;
  }
}

void SliceView::mouseReleaseEvent(QMouseEvent* event) {
  const Drag ended = drag_;
  drag_ = Drag::None;
  if (ended == Drag::Seed) finish_seed();
  if (ended == Drag::WindowLevel) {
    workbench_.view.window_level_armed = false;
    workbench_.view_edited();
  }
  if (ended == Drag::Zoom && !moved_ && gesture(Where::Slices, Mouse::RightClick, {}) == Act::ContextMenu) {
    show_menu(event->position(), event->globalPosition().toPoint());
  }
  update();
}

void SliceView::mouseDoubleClickEvent(QMouseEvent* event) {
  // With the tools that place things two quick clicks are two places.
  const ViewState& view = workbench_.view;
  const bool plain = event->button() == Qt::LeftButton && !view.window_level_armed && view.tool != Tool::Point &&
                     view.tool != Tool::Seed;
  if (plain && gesture(Where::Slices, Mouse::DoubleClick, event->modifiers()) == Act::Maximise) {
    emit maximise_wanted();
  } else {
    mousePressEvent(event);
  }
}

void SliceView::wheelEvent(QWheelEvent* event) {
  if (!workbench_.has_volume()) return;
  const double degrees = event->angleDelta().y() / 8.0;
  const std::optional<Act> act = gesture(Where::Slices, Mouse::Wheel, event->modifiers());
  if (act == Act::WheelZoom) {
    zoom_about(event->position(), std::exp(-degrees / 15 * 0.15));
  } else if (act == Act::WheelSlice) {
    // A touchpad sends small angles: they add up to notches of 15 degrees.
    wheel_degrees_ += degrees;
    const int notches = static_cast<int>(wheel_degrees_ / 15);
    wheel_degrees_ -= 15.0 * notches;
    if (notches) step_slice(notches);
  }
  event->accept();
}

void SliceView::keyPressEvent(QKeyEvent* event) {
  const std::optional<Act> act = key_in(Where::Slices, *event);
  if (!act || !workbench_.has_volume()) {
    View::keyPressEvent(event);
    return;
  }
  const Eigen::Vector3d spacing = slice_spacing_mm(workbench_.session().volume().geometry());
  const auto move = [&](const Eigen::Vector3d& direction, int voxels) {
    workbench_.set_crosshair(workbench_.view.crosshair_mm + voxels * direction.cwiseProduct(spacing));
  };
  const SliceAxes axes = this->axes();
  switch (*act) {
    case Act::CursorLeft:
      move(-axes.right, 1);
      break;
    case Act::CursorRight:
      move(axes.right, 1);
      break;
    case Act::CursorUp:
      move(axes.up, 1);
      break;
    case Act::CursorDown:
      move(-axes.up, 1);
      break;
    case Act::CursorLeft5:
      move(-axes.right, 5);
      break;
    case Act::CursorRight5:
      move(axes.right, 5);
      break;
    case Act::CursorUp5:
      move(axes.up, 5);
      break;
    case Act::CursorDown5:
      move(-axes.up, 5);
      break;
    case Act::NextSlice:
      step_slice(1);
      break;
    case Act::PreviousSlice:
      step_slice(-1);
      break;
    default:
      View::keyPressEvent(event);
  }
}

void SliceView::leaveEvent(QEvent* event) {
  if (workbench_.view.hovered_point && drag_ == Drag::None) {
    workbench_.view.hovered_point = 0;
    workbench_.view_edited();
  }
  View::leaveEvent(event);
}

void SliceView::show_menu(const QPointF& pixel, const QPoint& global) {
  const Eigen::Vector3d world = world_of(pixel);
  const ItemId point = point_at(pixel), mesh = mesh_at(pixel);
  QMenu menu(this);
  menu.setToolTipsVisible(true);
  if (point) {
    menu.addAction(tr("Delete this point"), [=, this] { workbench_.apply(DeleteAttractionPoint{point}); });
    menu.addSeparator();
  }
  QAction* add = menu.addAction(tr("Add attraction point here"), [=, this] {
    workbench_.apply(AddAttractionPoint{workbench_.view.active_mesh, world});
  });
  if (!workbench_.active_mesh()) {
    add->setEnabled(false);
    add->setToolTip(tr("There is no mesh that it could attract"));
  }
  if (const MeshItem* item = workbench_.scene().find_mesh(mesh); item && mesh != workbench_.view.active_mesh) {
    menu.addAction(tr("Make \"%1\" active").arg(QString::fromStdString(item->name)),
                   [=, this] { workbench_.set_active_mesh(mesh); });
  }
  menu.addAction(tr("Crosshair here"), [=, this] { workbench_.set_crosshair(world); });
  menu.exec(global);
}

void SliceView::update_cursor() {
  const ViewState& view = workbench_.view;
  if (view.window_level_armed) {
    setCursor(Qt::SizeAllCursor);
  } else if (view.hovered_point) {
    setCursor(Qt::PointingHandCursor);
  } else {
    setCursor(view.tool == Tool::ZoomPan     ? Qt::OpenHandCursor
              : view.tool == Tool::Crosshair ? Qt::ArrowCursor
                                             : Qt::CrossCursor);
  }
}

}  // namespace simplexseg
