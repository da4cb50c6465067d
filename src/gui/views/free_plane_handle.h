// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <utility>

#include "gui/drawing/painters.h"
#include "gui/views/screen_map.h"

namespace simplexseg {

class Workbench;

/// Handle of the free cutting plane: an arrow that moves it along its normal, and a ring that tilts it.
class FreePlaneHandle {
 public:
  enum class Part { None, Move, Tilt };
  explicit FreePlaneHandle(Workbench& workbench) : workbench_(workbench) {}

  /// The handle is drawn and can be dragged.
  bool is_shown() const;
  /// Draws the handle over everything else, and the border of the plane in the volume.
  void draw(const Projection& projection, const ScreenMap& map, double pixel_ratio, LinePainter& lines,
            DiscPainter& discs);
  /// Part within 9 logical pixels.
  Part part_at(const ScreenMap& map, const QPointF& pixel) const;
  /// Marks the part under the mouse; returns true if it has changed.
  bool hover(const ScreenMap& map, const QPointF& pixel);
  /// Unmarks it; returns true if a part was marked.
  bool leave() { return std::exchange(hovered_, Part::None) != Part::None; }
  Part hovered() const { return hovered_; }
  /// Begins a drag; returns false if no part is within reach.
  bool press(const ScreenMap& map, const QPointF& pixel);
  bool is_dragged() const { return dragged_ != Part::None; }
  void drag(const ScreenMap& map, const QPointF& pixel);
  void release() { dragged_ = Part::None; }
  /// Moves the plane along its normal, mm.
  void move(double mm);
  /// Places the plane at the crosshair, parallel to the screen; the side of the viewer is removed.
  void face_camera(const ScreenMap& map);

 private:
  struct Shape {
    Eigen::Vector3d centre_mm, tip_mm;
    std::array<Eigen::Vector3d, 4> rim_mm;
    Eigen::Vector3d normal, u, v;  ///< unit vectors; normal: to the side that is removed
    double radius_mm;
  };
  Shape shape(const ScreenMap& map) const;
  void draw_border(const Projection& projection, const Shape& shape, float width_px, LinePainter& lines) const;
  void tilt(const ScreenMap& map, const QPointF& pixel);

  Workbench& workbench_;
  Part hovered_ = Part::None, dragged_ = Part::None;
  Eigen::Vector3d u_{1, 0, 0};    ///< direction of the first disc on the ring, nearly in the plane
  Eigen::Vector3d rim_{1, 0, 0};  ///< direction of the disc that is dragged
  QPointF last_;
};

}  // namespace simplexseg
