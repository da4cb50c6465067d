// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "gui/drawing/label_painter.h"
#include "gui/drawing/painters.h"

class QMouseEvent;

namespace simplexseg {

class SliceView;
class Workbench;

/// Landmarks of a registration in a slice view (ViewState::landmarks): clicks place them while they are awaited.
class LandmarkOverlay {
 public:
  LandmarkOverlay(Workbench& workbench, SliceView& view) : workbench_(workbench), view_(view) {}
  void create() { discs_.create(); }
  void destroy() { discs_.destroy(); }
  /// Draws the points near the slice: of the volume, or of the layer while its point is awaited.
  void draw(const Projection& projection);
  /// Adds their numbers, and what the next click places. `box`: place of texts.
  void add_labels(std::vector<Label>& labels, const QRectF& box) const;
  /// Places a point if one is awaited. Returns whether it uses the event.
  bool press(const QMouseEvent& event);

 private:
  struct Point {
    Eigen::Vector3d at_mm;
    std::size_t number;
    double opacity;
  };
  std::vector<Point> points() const;

  Workbench& workbench_;
  SliceView& view_;
  DiscPainter discs_;
};

}  // namespace simplexseg
