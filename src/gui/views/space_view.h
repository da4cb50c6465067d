// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QElapsedTimer>
#include <QTimer>

#include "gui/input/bindings.h"
#include "gui/look/slice_geometry.h"
#include "gui/views/free_plane_handle.h"
#include "gui/views/orbit_camera.h"
#include "gui/views/point_springs.h"
#include "gui/views/point_wheel.h"
#include "gui/views/screen_map.h"
#include "gui/views/space_solids.h"
#include "gui/views/view.h"

namespace simplexseg {

/// 3D view of the meshes, the three slices, the points and the volume.
class SpaceView : public View {
  Q_OBJECT
 public:
  SpaceView(Workbench& workbench, DrawnScene& drawn, QWidget* parent);
  ~SpaceView() override;

  void fit() override;
  void centre_on_crosshair() override;
  /// Software renderers need more time for this view than for the slices together: there, it is repainted at most ten
  /// times a second.
  void show_progress() override;
  /// Copies the camera of another view.
  void copy_camera(const SpaceView& other);
  /// Places the free cutting plane at the crosshair, parallel to the screen.
  void face_free_plane() { plane_handle_.face_camera(map()); }
  ScreenMap map() const;
  SpaceSolids& solids() { return solids_; }

 signals:
  /// The camera was rotated, moved, zoomed, fitted or centred; not emitted by copy_camera().
  void camera_changed();

 protected:
  void create_painters() override;
  void destroy_painters() override;
  void prepare() override;
  void paint() override;
  void annotate(std::vector<Label>& labels) const override;

  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void leaveEvent(QEvent* event) override;

 private:
  Projection projection() const;
  double aspect() const;
  void draw_slices(const Projection& projection);
  void draw_frames(const Projection& projection);
  void draw_points(const Projection& projection);
  void draw_stroke(const Projection& projection, const UserPoint& point, const Rgba& colour);
  void draw_springs(const Projection& projection);
  void draw_scale(const Projection& projection);
  /// Draws a circle parallel to the screen.
  void draw_circle(const Projection& projection, const Eigen::Vector3d& centre_mm, double radius_mm,
                   const Rgba& colour);
  QRectF scale_box() const;
  /// Nearest point whose handle is within 9 logical pixels; 0 if there is none, it is cut away or an opaque mesh hides
  /// it.
  ItemId point_at(const QPointF& pixel) const;
  void hover(const QPointF& pixel);
  void drag_point(const QPointF& pixel);
  void pick(const QPointF& pixel);

  bool is_software_ = false;
  QElapsedTimer since_paint_;
  QTimer late_;  ///< repaints after changes that were not shown at once
  OrbitCamera camera_;
  PointWheel point_wheel_;
  ItemId dragged_point_ = 0;
  bool drag_continues_ = false;  ///< the first command of the drag has been applied
  Eigen::Vector3d grab_offset_mm_{0, 0, 0};
  QPointF press_;
  std::optional<Act> drag_;
  QPointF last_;
  const SceneBuffers::Slice* slices_[3] = {};  ///< set by prepare(), like the next
  const PointSprings* springs_ = nullptr;
  SlicePainter slice_painter_;
  LinePainter line_painter_;
  DiscPainter disc_painter_;
  SpaceSolids solids_;
  FreePlaneHandle plane_handle_;
};

}  // namespace simplexseg
