// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QPointF>
#include <optional>

#include "gui/views/point_wheel.h"
#include "session/scene.h"

class QKeyEvent;
class QMouseEvent;
class QPoint;
class QWheelEvent;

namespace simplexseg {

class SliceView;
class Workbench;

/// What mouse and keys do in a slice. What a gesture means is looked up in the table of bindings; a drag is remembered
/// from its press to its release.
class SliceTools {
 public:
  SliceTools(Workbench& workbench, SliceView& view);

  // Each is given the event of its name that came to the view.
  void press(const QMouseEvent& event);
  void move(const QMouseEvent& event);
  void release(const QMouseEvent& event);
  /// False when the double click is no press for a tool: the view is to be maximised.
  bool double_click(const QMouseEvent& event);
  void wheel(const QWheelEvent& event);
  /// False when the key means nothing here.
  bool key(const QKeyEvent& event);
  void leave();
  /// Points have come or gone: what lies under the mouse may be another.
  void follow_points();

  /// Whether a drag from where the mouse is would pull the active mesh's outline.
  bool grabs() const { return grabs_; }
  /// The sphere that is being placed, from its press to its release.
  const std::optional<Seed>& seed() const { return seed_; }

 private:
  enum class Drag { None, Crosshair, Grab, Point, Zoom, Pan, WindowLevel, Seed };

  /// The point whose handle is within 8 px of the place, 0 if none; of several the nearest.
  ItemId point_at(const QPointF& pixel) const;
  /// The mesh whose outline is within 8 px, else the one that the place lies in, 0 if none.
  ItemId mesh_at(const QPointF& pixel) const;
  /// Whether the active mesh's outline is within 4 px and a drag there pulls it: with the crosshair, on no point.
  bool grabs_at(const QPointF& pixel, Qt::KeyboardModifiers modifiers) const;
  void begin_left_drag(const QPointF& pixel, Qt::KeyboardModifiers modifiers);
  void begin_point(const QPointF& pixel, MarkKind kind);
  /// Adds a point to the active mesh; 0 when that fails, which is said.
  ItemId add_point(const Eigen::Vector3d& world_mm, MarkKind kind);
  void drag_point(const QPointF& pixel);
  void drag_window_level(const QPointF& moved);
  void begin_seed(const Eigen::Vector3d& centre_mm);
  void finish_seed();
  /// Moves the crosshair along a direction of the screen.
  void move_crosshair(const Eigen::Vector3d& direction, int voxels);
  void hover(const QPointF& pixel, Qt::KeyboardModifiers modifiers);
  void show_grab(bool grabs);
  void show_menu(const QPointF& pixel, const QPoint& global);

  Workbench& workbench_;
  SliceView& view_;
  Drag drag_ = Drag::None;
  ItemId dragged_point_ = 0;
  bool drag_continues_ = false;              ///< the session knows of the drag already
  Eigen::Vector3d grab_offset_mm_{0, 0, 0};  ///< from the mouse to the handle
  QPointF press_, last_;
  std::optional<QPointF> mouse_;  ///< while it is over the view
  bool moved_ = false;            ///< far enough from the press to be no click
  /// Where the crosshair was before the last click moved it; none after anything else.
  std::optional<Eigen::Vector3d> before_click_mm_;
  bool grabs_ = false;
  PointWheel point_wheel_;
  double wheel_degrees_ = 0;  ///< turned since the last whole notch
  std::optional<Seed> seed_;
};

}  // namespace simplexseg
