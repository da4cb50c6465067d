// SPDX-License-Identifier: Apache-2.0
#include "gui/views/slice_tools.h"

#include <QKeyEvent>
#include <QMouseEvent>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "gui/input/key_map.h"
#include "gui/look/point_style.h"
#include "gui/views/slice_hits.h"
#include "gui/views/slice_menu.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr double kGrabRadius = 4;  // largest distance at which a contour can be pulled, logical pixels
constexpr double kDragStarts = 3;  // shortest drag, logical pixels; a shorter movement is a click

std::optional<MarkKind> kind_of(Tool tool) {
  switch (tool) {
    case Tool::Point:
      return MarkKind::Boundary;
    case Tool::Inside:
      return MarkKind::Inside;
    case Tool::Outside:
      return MarkKind::Outside;
    default:
      return std::nullopt;
  }
}

}  // namespace

SliceTools::SliceTools(Workbench& workbench, SliceView& view)
    : workbench_(workbench),
      view_(view),
      point_wheel_(workbench),
      stroke_tool_(workbench),
      measure_tool_(workbench, view) {}

bool SliceTools::grabs_at(const QPointF& pixel, Qt::KeyboardModifiers modifiers) const {
  const ViewState& view = workbench_.view;
  if (view.tool != Tool::Crosshair || view.window_level_armed || point_in_slice(workbench_, view_, pixel)) return false;
  if (measure_tool_.grabs_at(pixel)) return false;
  if (gesture(Where::Slices, Mouse::Left, modifiers) != Act::MoveCrosshair) return false;
  const auto pixel_of = [this](const Vec3& at) { return view_.pixel_of({at.x, at.y, at.z}); };
  const std::span<const OutlineSegment> outline = view_.active_outline();
  return std::any_of(outline.begin(), outline.end(), [&](const OutlineSegment& piece) {
    return distance_to_segment(pixel, pixel_of(piece.start), pixel_of(piece.end)) <= kGrabRadius;
  });
}

void SliceTools::begin_left_drag(const QPointF& pixel, Qt::KeyboardModifiers modifiers) {
  ViewState& view = workbench_.view;
  if (view.window_level_armed) {
    drag_ = Drag::WindowLevel;
    return;
  }
  const std::optional<Act> act = gesture(Where::Slices, Mouse::Left, modifiers);
  if (!act) return;
  const ItemId under = point_in_slice(workbench_, view_, pixel);
  if (*act == Act::MoveCrosshair && (!under || measures(view.tool)) && measure_tool_.press(pixel)) {
    drag_ = Drag::Measurement;
    return;
  }
  if (grabs_at(pixel, modifiers)) {
    drag_ = Drag::Grab;
    return;
  }
  if (paints(view.tool) && *act == Act::MoveCrosshair) {
    begin_paint(pixel);
    return;
  }
  switch (*act) {
    case Act::AddPoint:
      begin_point(pixel, MarkKind::Boundary);
      return;
    case Act::ErasePoint:
      if (under) workbench_.apply(DeletePoint{under});
      return;
    case Act::PickMesh:
      workbench_.set_active_mesh(mesh_in_slice(workbench_, view_, pixel));
      return;
    default:
      break;
  }
  if (view.tool == Tool::ZoomPan) {
    drag_ = Drag::Pan;
  } else if (view.tool == Tool::Seed) {
    begin_seed(view_.world_of(pixel));
  } else if (view.lasso && (view.tool == Tool::Box || (view.tool == Tool::Inside && !workbench_.active_mesh()))) {
    drag_ = Drag::Stroke;
    stroke_tool_.begin_start(view_.world_of(pixel), Eigen::Vector3d::Unit(view_.axes().normal));
  } else if (draws_box(view.tool)) {
    drag_ = Drag::Box;
    samples_range_ = view.tool == Tool::Range;
  } else if (under) {
    drag_ = Drag::Point;
    dragged_point_ = under;
    drag_continues_ = false;
    // The handle keeps its offset from the slice and from the mouse.
    grab_offset_mm_ = workbench_.scene().find_point(under)->position_mm - view_.world_of(pixel);
    view.selected_point = under;
    workbench_.view_edited();
  } else if (const std::optional<MarkKind> kind = kind_of(view.tool)) {
    if (*kind == MarkKind::Boundary)
      begin_point(pixel, *kind);
    else
      begin_stroke(pixel, *kind);
  } else {
    drag_ = Drag::Crosshair;
    workbench_.set_crosshair(view_.crosshair_at(pixel));
  }
}

bool SliceTools::require_active_mesh() {
  const MeshItem* const item = workbench_.active_mesh();
  if (item && !item->locked) return true;
  workbench_.notify(
      Severity::Warning,
      item ? why_locked()
           : SliceView::tr("A point needs a segmentation: place a seed first (%1)").arg(key_hint(Act::ToolSeed)));
  return false;
}

ItemId SliceTools::add_point(const Eigen::Vector3d& world_mm, MarkKind kind) {
  ItemId point = 0;
  AddPoint command{workbench_.view.active_mesh, world_mm, kind};
  command.local = workbench_.view.local_marks;
  if (require_active_mesh()) workbench_.apply(command, &point);
  return point;
}

void SliceTools::begin_stroke(const QPointF& pixel, MarkKind kind) {
  if (!require_active_mesh()) return;
  drag_ = Drag::Stroke;
  stroke_tool_.begin(kind, view_.world_of(pixel), Eigen::Vector3d::Unit(view_.axes().normal));
}

void SliceTools::begin_paint(const QPointF& pixel) {
  const Eigen::Vector3d at_mm = view_.world_of(pixel);
  if (!require_active_mesh() || !workbench_.session().volume().geometry().contains(at_mm)) return;
  drag_ = Drag::Stroke;
  stroke_tool_.begin_paint(at_mm, Eigen::Vector3d::Unit(view_.axes().normal));
  view_.update();
}

std::optional<Eigen::Vector3d> SliceTools::brush_centre_mm() const {
  if (!mouse_ || !paints(workbench_.view.tool) || !workbench_.has_volume()) return std::nullopt;
  return view_.world_of(*mouse_);
}

void SliceTools::begin_point(const QPointF& pixel, MarkKind kind) {
  const ItemId point = add_point(view_.world_of(pixel), kind);
  if (!point) return;
  drag_ = Drag::Point;
  dragged_point_ = point;
  drag_continues_ = true;
  grab_offset_mm_.setZero();
}

void SliceTools::drag_point(const QPointF& pixel) {
  if (!workbench_.scene().find_point(dragged_point_)) {
    drag_ = Drag::None;
    return;
  }
  if (workbench_.apply(MovePoint{dragged_point_, view_.world_of(pixel) + grab_offset_mm_, drag_continues_}))
    drag_continues_ = true;
  else if (is_locked(workbench_.scene(), dragged_point_))
    drag_ = Drag::None;  // one message per drag
}

void SliceTools::drag_window_level(const QPointF& moved) {
  ViewState& view = workbench_.view;
  // A vertical drag of 250 logical pixels changes the level by the width of the window.
  const double intensity_per_pixel = std::max(view.window, 1e-9) / 250;
  view.window = std::max(view.window + moved.x() * intensity_per_pixel, 1e-9);
  view.level += moved.y() * intensity_per_pixel;
  workbench_.view_edited();
}

void SliceTools::begin_seed(const Eigen::Vector3d& centre_mm) {
  if (!workbench_.session().volume().geometry().contains(centre_mm)) {
    workbench_.notify(Severity::Warning,
                      SliceView::tr("The seed would lie outside the image. Drag from the centre of the structure to "
                                    "its edge."));
    return;
  }
  drag_ = Drag::Seed;
  seed_ = Seed{centre_mm, 0};
}

void SliceTools::finish_seed() {
  const std::optional<Seed> seed = std::exchange(seed_, std::nullopt);
  if (!seed) return;
  if (seed->radius_mm < 2 * view_.mm_per_pixel()) {
    workbench_.notify(Severity::Note,
                      SliceView::tr("New segmentation: drag from the centre of the structure to its edge"));
    return;
  }
  if (workbench_.apply(AddMesh{{}, *seed, std::nullopt, workbench_.view.active_mesh})) end_start();
}

void SliceTools::end_start() {
  workbench_.view.tool = Tool::Crosshair;
  workbench_.view_edited();
  emit workbench_.mesh_placed();
}

void SliceTools::show_grab(bool grabs) {
  if (std::exchange(grabs_, grabs) == grabs) return;
  view_.update_cursor();
  view_.update();
}

void SliceTools::hover(const QPointF& pixel, Qt::KeyboardModifiers modifiers) {
  show_grab(grabs_at(pixel, modifiers));
  measure_tool_.move(pixel, false);
  measure_tool_.hover(pixel);
  update_hovered_point();
  if (paints(workbench_.view.tool)) view_.update();
}

void SliceTools::update_hovered_point() {
  if (!mouse_ || drag_ != Drag::None) return;
  const ItemId under = point_in_slice(workbench_, view_, *mouse_);
  if (under == workbench_.view.hovered_point) return;
  workbench_.view.hovered_point = under;
  workbench_.view_edited();
}

void SliceTools::press(const QMouseEvent& event) {
  if (!workbench_.has_volume() || drag_ != Drag::None) return;
  press_ = last_ = event.position();
  moved_ = false;
  before_click_mm_ = workbench_.view.crosshair_mm;
  if (event.button() == Qt::LeftButton) {
    begin_left_drag(event.position(), event.modifiers());
    return;
  }
  const Mouse mouse = event.button() == Qt::RightButton ? Mouse::Right : Mouse::Middle;
  const std::optional<Act> act = gesture(Where::Slices, mouse, {});
  if (act == Act::Zoom) drag_ = Drag::Zoom;
  if (act == Act::Pan) drag_ = Drag::Pan;
}

void SliceTools::move(const QMouseEvent& event) {
  if (!workbench_.has_volume()) return;
  const QPointF here = event.position(), moved = here - last_;
  last_ = here;
  mouse_ = here;
  moved_ |= pixel_length(here - press_) >= kDragStarts;
  switch (drag_) {
    case Drag::None:
      hover(here, event.modifiers());
      if (event.buttons() == Qt::NoButton &&
          gesture(Where::Slices, Mouse::Move, event.modifiers()) == Act::FollowMouse) {
        workbench_.set_crosshair(view_.crosshair_at(here));
      }
      break;
    case Drag::Crosshair:
      workbench_.set_crosshair(view_.crosshair_at(here));
      break;
    case Drag::Grab:
      // The drag starts only when the mouse moves, because a click on the contour moves the crosshair.
      if (moved_) {
        drag_ = Drag::None;
        begin_point(press_, MarkKind::Boundary);
        if (drag_ == Drag::Point) drag_point(here);
      }
      break;
    case Drag::Point:
      // A click on a handle selects the point, and must not move it by accident.
      if (moved_ || drag_continues_) drag_point(here);
      break;
    case Drag::Stroke:
      if (moved_) stroke_tool_.extend(view_.world_of(here));
      view_.update();
      break;
    case Drag::Box:
      view_.update();
      break;
    case Drag::Measurement:
      measure_tool_.move(here, moved_);
      break;
    case Drag::Zoom:
      if (moved_) view_.zoom_about(press_, std::exp(moved.y() * 0.01));
      break;
    case Drag::Pan:
      view_.pan(moved);
      break;
    case Drag::WindowLevel:
      drag_window_level(moved);
      break;
    case Drag::Seed:
      seed_->radius_mm = (view_.world_of(here) - seed_->centre_mm).norm();
      view_.update();
      break;
  }
}

void SliceTools::release(const QMouseEvent& event) {
  const Drag ended = drag_;
  if (ended == Drag::Box) finish_box();
  drag_ = Drag::None;
  if (ended == Drag::Seed) finish_seed();
  if (ended == Drag::Measurement) measure_tool_.release(event.position(), moved_);
  if (ended == Drag::Stroke && stroke_tool_.finish()) end_start();
  if (ended == Drag::Grab) workbench_.set_crosshair(view_.crosshair_at(press_));
  if (ended == Drag::WindowLevel) {
    workbench_.view.window_level_armed = false;
    workbench_.view_edited();
  }
  if (ended == Drag::Zoom && !moved_ && gesture(Where::Slices, Mouse::RightClick, {}) == Act::ContextMenu) {
    const Eigen::Vector3d world = view_.world_of(event.position());
    show_slice_menu(workbench_, view_, measure_tool_, event.position(), event.globalPosition().toPoint(),
                    [=, this](MarkKind kind) { add_point(world, kind); });
  }
  if (moved_) before_click_mm_.reset();
  view_.update();
}

bool SliceTools::double_click(const QMouseEvent& event) {
  // With tools that place points or seeds, a double click acts as two clicks.
  const ViewState& view = workbench_.view;
  const bool plain = event.button() == Qt::LeftButton && !view.window_level_armed && !kind_of(view.tool) &&
                     !paints(view.tool) && view.tool != Tool::Seed && !draws_box(view.tool) && !measures(view.tool);
  if (plain && gesture(Where::Slices, Mouse::DoubleClick, event.modifiers()) == Act::Maximise) {
    // Undoes the crosshair movement of the first click.
    if (const auto before = std::exchange(before_click_mm_, std::nullopt)) workbench_.set_crosshair(*before);
    return false;
  }
  press(event);
  return true;
}

void SliceTools::wheel(const QWheelEvent& event) {
  if (!workbench_.has_volume()) return;
  const ItemId point = point_in_slice(workbench_, view_, event.position());
  if (drag_ == Drag::None && point_wheel_.handles(point) &&
      gesture(Where::Slices, Mouse::WheelOnPoint, event.modifiers())) {
    point_wheel_.turn(point, event, true);
    return;
  }
  point_wheel_.record_other_use();
  const double degrees = event.angleDelta().y() / 8.0;
  const std::optional<Act> act = gesture(Where::Slices, Mouse::Wheel, event.modifiers());
  if (act == Act::WheelZoom) {
    view_.zoom_about(event.position(), std::exp(-degrees / 15 * 0.15));
  } else if (act == Act::BrushSize) {
    // Some desktops report a horizontal wheel while Shift is held.
    const QPoint angle = event.angleDelta();
    if (paints(workbench_.view.tool)) stroke_tool_.resize_brush((angle.y() != 0 ? angle.y() : angle.x()) / 120.0);
  } else if (act == Act::WheelSlice) {
    // A touchpad sends small angles, which are added up to notches of 15 degrees.
    wheel_degrees_ += degrees;
    const int notches = static_cast<int>(wheel_degrees_ / 15);
    wheel_degrees_ -= 15.0 * notches;
    if (notches) view_.move_by_slices(notches);
  }
}

bool SliceTools::uses_key(const QKeyEvent& event) const {
  return measure_tool_.draft() && key_in(Where::Everywhere, event) == Act::CancelSolving;
}

bool SliceTools::key(const QKeyEvent& event) {
  if (uses_key(event)) return measure_tool_.cancel();
  const std::optional<Act> act = key_in(Where::Slices, event);
  if (!act || !workbench_.has_volume()) return false;
  const SliceAxes axes = view_.axes();
  switch (*act) {
    case Act::CrosshairLeft:
      move_crosshair(-axes.right, 1);
      return true;
    case Act::CrosshairRight:
      move_crosshair(axes.right, 1);
      return true;
    case Act::CrosshairUp:
      move_crosshair(axes.up, 1);
      return true;
    case Act::CrosshairDown:
      move_crosshair(-axes.up, 1);
      return true;
    case Act::CrosshairLeft5:
      move_crosshair(-axes.right, 5);
      return true;
    case Act::CrosshairRight5:
      move_crosshair(axes.right, 5);
      return true;
    case Act::CrosshairUp5:
      move_crosshair(axes.up, 5);
      return true;
    case Act::CrosshairDown5:
      move_crosshair(-axes.up, 5);
      return true;
    case Act::NextSlice:
      view_.move_by_slices(1);
      return true;
    case Act::PreviousSlice:
      view_.move_by_slices(-1);
      return true;
    case Act::AddInside:
    case Act::AddOutside:
      // Ignores key repeat, and keys during a drag.
      if (mouse_ && !event.isAutoRepeat() && drag_ == Drag::None)
        add_point(view_.world_of(*mouse_), *act == Act::AddInside ? MarkKind::Inside : MarkKind::Outside);
      return true;
    default:
      return false;
  }
}

void SliceTools::move_crosshair(const Eigen::Vector3d& direction, int voxels) {
  const Eigen::Vector3d spacing_mm = slice_spacing_mm(workbench_.session().volume().geometry());
  workbench_.set_crosshair(workbench_.view.crosshair_mm + voxels * direction.cwiseProduct(spacing_mm));
}

void SliceTools::leave() {
  mouse_.reset();
  if (paints(workbench_.view.tool)) view_.update();
  show_grab(false);
  measure_tool_.hover(std::nullopt);
  if (!workbench_.view.hovered_point || drag_ != Drag::None) return;
  workbench_.view.hovered_point = 0;
  workbench_.view_edited();
}

}  // namespace simplexseg
