// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QPointF>
#include <optional>

#include "gui/views/measure_tool.h"
#include "gui/views/point_wheel.h"
#include "gui/views/stroke_tool.h"
#include "session/scene.h"

class QKeyEvent;
class QMouseEvent;
class QWheelEvent;

namespace simplexseg {

class SliceView;
class Workbench;

/// Mouse and keyboard input of a slice view, according to the table of bindings.
class SliceTools {
 public:
  SliceTools(Workbench& workbench, SliceView& view);

  // Handlers of the view's events.
  void press(const QMouseEvent& event);
  void move(const QMouseEvent& event);
  void release(const QMouseEvent& event);
  /// Returns false if the view should be maximised, because no tool uses the double click.
  bool double_click(const QMouseEvent& event);
  void wheel(const QWheelEvent& event);
  /// Returns false if the key is not bound in slices, or if there is no volume.
  bool key(const QKeyEvent& event);
  /// Discards the measurement that is being drawn if the tool or the slice has changed.
  void discard_outdated_measurement() { measure_tool_.discard_outdated(); }
  /// Returns true if the view uses a key although it is a menu entry's.
  bool uses_key(const QKeyEvent& event) const;
  void leave();
  /// Updates the point under the mouse, after points were added or deleted.
  void update_hovered_point();

  /// Returns true if a drag from the mouse position would pull the active contour.
  bool grabs() const { return grabs_; }
  /// Seed sphere while the user drags it; otherwise none.
  const std::optional<Seed>& seed() const { return seed_; }
  /// Corners of the box while the user drags it, mm, in order; otherwise none.
  std::vector<Eigen::Vector3d> box_mm() const;
  /// Centre of the brush under the mouse, mm; none without a brush or outside the view.
  std::optional<Eigen::Vector3d> brush_centre_mm() const;
  /// Stroke while the user draws it; otherwise none.
  const std::optional<UserPoint>& stroke() const { return stroke_tool_.stroke(); }
  /// Measurement while the user draws it, which can have a defect; otherwise none.
  std::optional<Measurement> measurement() const { return measure_tool_.draft(); }

 private:
  enum class Drag { None, Crosshair, Grab, Point, Stroke, Zoom, Pan, WindowLevel, Seed, Box, Measurement };

  /// Returns true if a drag would pull the active contour: crosshair tool, contour within 4 logical pixels, no point.
  bool grabs_at(const QPointF& pixel, Qt::KeyboardModifiers modifiers) const;
  void begin_left_drag(const QPointF& pixel, Qt::KeyboardModifiers modifiers);
  void begin_point(const QPointF& pixel, MarkKind kind);
  void begin_paint(const QPointF& pixel);
  void begin_stroke(const QPointF& pixel, MarkKind kind);
  /// Returns true if a mesh is active; otherwise shows a message that a point needs one.
  bool require_active_mesh();
  /// Adds a point to the active mesh, and returns its id; 0 after a failure, which becomes a message.
  ItemId add_point(const Eigen::Vector3d& world_mm, MarkKind kind);
  void drag_point(const QPointF& pixel);
  void drag_window_level(const QPointF& moved);
  void begin_seed(const Eigen::Vector3d& centre_mm);
  void finish_seed();
  void finish_box();
  /// Selects the tool with which the next drag corrects the new segmentation.
  void end_start();
  /// Moves the crosshair by a number of voxels along a screen axis (unit vector, LPS).
  void move_crosshair(const Eigen::Vector3d& direction, int voxels);
  void hover(const QPointF& pixel, Qt::KeyboardModifiers modifiers);
  void show_grab(bool grabs);

  Workbench& workbench_;
  SliceView& view_;
  Drag drag_ = Drag::None;
  ItemId dragged_point_ = 0;
  bool drag_continues_ = false;              ///< the first command of the drag has been applied
  Eigen::Vector3d grab_offset_mm_{0, 0, 0};  ///< vector from the mouse to the handle
  bool samples_range_ = false;               ///< the rectangle that is dragged sets a range, instead of a box
  QPointF press_, last_;
  std::optional<QPointF> mouse_;  ///< mouse position; none outside the view
  bool moved_ = false;            ///< the mouse has moved too far since the press for a click
  /// Crosshair before the last press of a button, mm; none after a drag or a double click.
  std::optional<Eigen::Vector3d> before_click_mm_;
  bool grabs_ = false;
  PointWheel point_wheel_;
  StrokeTool stroke_tool_;
  MeasureTool measure_tool_;
  double wheel_degrees_ = 0;  ///< rotation since the last whole notch, degrees
  std::optional<Seed> seed_;
};

}  // namespace simplexseg
