// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "gui/input/bindings.h"
#include "gui/look/slice_geometry.h"
#include "gui/views/view.h"

namespace simplexseg {

/// One slice through the crosshair with all that lies on it, and the tools that work on it.
class SliceView : public View {
  Q_OBJECT
 public:
  SliceView(Workbench& workbench, DrawnScene& drawn, Orientation orientation, QWidget* parent);
  ~SliceView() override;

  void fit() override;
  void centre_on_crosshair() override;

  Orientation orientation() const { return orientation_; }
  /// Between widget coordinates (logical pixels) and the plane of the slice.
  Eigen::Vector3d world_of(const QPointF& pixel) const;
  QPointF pixel_of(const Eigen::Vector3d& world_mm) const;
  double mm_per_pixel() const { return mm_per_pixel_; }
  /// Moves the crosshair by whole slices.
  void step_slice(int slices);

 protected:
  void create_painters() override;
  void destroy_painters() override;
  void prepare() override;
  void paint() override;
  void annotate(std::vector<Label>& labels) const override;

  void resizeEvent(QResizeEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void leaveEvent(QEvent* event) override;

 private:
  enum class Drag { None, Crosshair, Point, Zoom, Pan, WindowLevel, Seed };

  SliceAxes axes() const;
  double slice_mm() const;
  double distance_to_slice_mm(const Eigen::Vector3d& world_mm) const;
  Projection projection() const;
  void draw_outlines(const Projection& projection);
  void draw_crosshair(const Projection& projection);
  void draw_points(const Projection& projection);
  void draw_seed(const Projection& projection);
  QString corner_text() const;
  QRectF text_box() const;

  /// The point whose handle is within 8 px of the place, 0 if none; of several the nearest.
  ItemId point_at(const QPointF& pixel) const;
  /// The mesh whose outline is within 8 px, else the one that the place lies in, 0 if none.
  ItemId mesh_at(const QPointF& pixel) const;
  void begin_left_drag(const QPointF& pixel, Qt::KeyboardModifiers modifiers);
  void begin_point(const QPointF& pixel);
  void drag_point(const QPointF& pixel);
  void drag_window_level(const QPointF& moved);
  void finish_seed();
  void hover(const QPointF& pixel);
  void zoom_about(const QPointF& pixel, double factor);
  void show_menu(const QPointF& pixel, const QPoint& global);
  void update_cursor();

  const Orientation orientation_;
  Eigen::Vector3d centre_mm_{0, 0, 0};  ///< of the widget, in the plane
  double mm_per_pixel_ = 1;             ///< logical pixels
  bool fitted_ = true;                  ///< follows the size of the widget until zoomed or panned

  Drag drag_ = Drag::None;
  ItemId dragged_point_ = 0;
  bool drag_continues_ = false;              ///< the session knows of the drag already
  Eigen::Vector3d grab_offset_mm_{0, 0, 0};  ///< of the handle from the mouse
  QPointF press_, last_;
  bool moved_ = false;
  double wheel_degrees_ = 0;
  Eigen::Vector3d seed_centre_mm_{0, 0, 0};
  double seed_radius_mm_ = 0;

  const SceneBuffers::Slice* slice_ = nullptr;  ///< as of prepare()
  const SceneBuffers::Outlines* outlines_ = nullptr;
  SlicePainter slice_painter_;
  OutlinePainter outline_painter_;
  LinePainter line_painter_;
  DiscPainter disc_painter_;
};

/// How visible a handle is at some distance from the slice: 1 on it, 0 where it is neither drawn nor hit.
double handle_opacity(double distance_mm);

}  // namespace simplexseg
