// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QPointF>
#include <optional>

#include "gui/look/view_state.h"
#include "gui/views/measurement_shape.h"

class QMenu;

namespace simplexseg {

/// Mouse input that draws, moves and deletes measurements in a slice view. A ruler or an ellipse is one drag; an angle
/// is three clicks, of which the first two can be a drag.
class MeasureTool {
 public:
  MeasureTool(Workbench& workbench, SliceView& view) : workbench_(workbench), view_(view) {}

  /// Begins or continues a measurement, or a drag of one under the mouse. Returns false if a press there does neither.
  bool press(const QPointF& pixel);
  /// Handles a movement of the mouse, with or without a button. `dragged`: the mouse has moved too far for a click
  /// since the press.
  void move(const QPointF& pixel, bool dragged);
  void release(const QPointF& pixel, bool dragged);
  /// Discards the measurement that is being drawn if the tool or the slice has changed.
  void discard_outdated();
  /// Discards the measurement that is being drawn. Returns false if there is none.
  bool cancel();
  /// Returns true if a press would drag a measurement.
  bool grabs_at(const QPointF& pixel) const;
  /// Updates the measurement under the mouse; none: the mouse has left the view.
  void hover(const std::optional<QPointF>& pixel);
  /// Adds the entries for the measurement under a position, and a separator; nothing without one.
  void add_entries(QMenu& menu, const QPointF& pixel);

  /// Measurement that is being drawn, with the points up to the mouse, so that it can have a defect (defect_of());
  /// otherwise none.
  std::optional<Measurement> draft() const;

 private:
  struct Draft {
    Tool tool;
    double slice_mm;
    std::vector<Eigen::Vector3d> points_mm;  ///< placed points; of a ruler or ellipse, the first corner
    Eigen::Vector3d mouse_mm;
  };
  struct Grab {
    MeasurementHit hit;
    Eigen::Vector3d offset_mm;  ///< vector from the mouse to the handle or to the first point
    bool continues = false;     ///< the first command of the drag has been applied
  };

  /// Returns true if the draft belongs to the tool and the slice of the view.
  bool is_current() const;
  void drag_to(const QPointF& pixel);
  /// Adds the measurement of the draft to the scene, or explains how to draw one.
  void finish();
  void rename(ItemId measurement);

  Workbench& workbench_;
  SliceView& view_;
  std::optional<Draft> draft_;
  std::optional<Grab> grab_;
};

}  // namespace simplexseg
