// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "gui/look/slice_geometry.h"
#include "gui/views/landmark_overlay.h"
#include "gui/views/layer_overlay.h"
#include "gui/views/measurement_layer.h"
#include "gui/views/paint_outline.h"
#include "gui/views/slice_tools.h"
#include "gui/views/view.h"

namespace simplexseg {

class PointSprings;

/// Opacity of a handle by its distance from the slice: 1 on the slice; 0 from 12 mm on, where the handle is neither
/// drawn nor selectable.
double handle_opacity(double distance_mm);

/// View of one slice: that through the crosshair, or a neighbour of it. SliceTools handles its input.
class SliceView : public View {
  Q_OBJECT
 public:
  /// `neighbour`: see slice_through_mm().
  SliceView(Workbench& workbench, DrawnScene& drawn, Orientation orientation, QWidget* parent, int neighbour = 0);
  ~SliceView() override;

  void fit() override;
  void centre_on_crosshair() override;
  /// Moves the image by the vector `by`, logical pixels.
  void pan(const QPointF& by);
  /// Multiplies mm_per_pixel() by `factor`, within bounds; the world position under `pixel` does not move. Needs a
  /// volume.
  void zoom_about(const QPointF& pixel, double factor);
  /// Copies centre and zoom of another view of the same orientation.
  void copy_frame(const SliceView& other);
  /// Moves the crosshair by a number of slices along the normal.
  void move_by_slices(int slices);

  Orientation orientation() const { return orientation_; }
  /// Shows slices of another orientation.
  void set_orientation(Orientation orientation);
  int neighbour() const { return neighbour_; }
  /// Point in the slice with the in-plane coordinates of the crosshair, mm. Needs a volume.
  Eigen::Vector3d through_mm() const;
  SliceAxes axes() const;
  /// World coordinate of the slice along its normal, mm.
  double slice_mm() const;
  double distance_to_slice_mm(const Eigen::Vector3d& world_mm) const;
  // Conversions between widget coordinates (logical pixels) and the plane of the slice.

  Eigen::Vector3d world_of(const QPointF& pixel) const;
  /// Place to which a click moves the crosshair. In a neighbour the crosshair stays in its slice, because this view
  /// shows the neighbour of the slice to which it would move.
  Eigen::Vector3d crosshair_at(const QPointF& pixel) const;
  QPointF pixel_of(const Eigen::Vector3d& world_mm) const;
  double mm_per_pixel() const { return mm_per_pixel_; }
  /// Segments of the active contour in the last image; none while meshes are hidden. Read back at most once per image.
  std::span<const OutlineSegment> active_outline();
  /// Sets the shape of the mouse pointer to the action that a press would start.
  void update_cursor();

 signals:
  /// The user has zoomed, panned, fitted or centred the view; not emitted by copy_frame().
  void frame_changed();

 protected:
  void create_painters() override;
  void destroy_painters() override;
  void prepare() override;
  void paint() override;
  void annotate(std::vector<Label>& labels) const override;

  bool event(QEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void leaveEvent(QEvent* event) override;

 private:
  Projection projection() const;
  /// Draws the image, with a tint on ViewState::range_preview.
  void draw_slice(const Projection& projection);
  void draw_field(const Projection& projection);
  void draw_outlines(const Projection& projection);
  void draw_crosshair(const Projection& projection);
  void draw_points(const Projection& projection);
  void draw_springs(const Projection& projection);
  void draw_scale_bar(const Projection& projection);
  void draw_marks(const Projection& projection);
  void draw_stroke(const Projection& projection, const UserPoint& stroke);
  void draw_paint(const Projection& projection);
  void draw_brush(const Projection& projection);
  QString brush_text() const;  ///< shape and size of the brush
  /// `width`: line width, logical pixels.
  void draw_circle(const Projection& projection, const Eigen::Vector3d& centre_mm, double radius_mm, const Rgba& colour,
                   float width);
  void draw_seed(const Projection& projection);
  QRectF text_box() const;

  Orientation orientation_;
  const int neighbour_;
  Eigen::Vector3d centre_mm_{0, 0, 0};  ///< world position of the centre of the widget
  double mm_per_pixel_ = 1;             ///< size of a logical pixel
  bool fitted_ = true;                  ///< fitted again on resize; false after zoom, pan or centring
  SliceTools tools_;

  const SceneBuffers::Slice* slice_ = nullptr;  ///< set by prepare(), like the next three
  const SceneBuffers::Outlines* outlines_ = nullptr;
  const SceneBuffers::Field* field_ = nullptr;
  const PointSprings* springs_ = nullptr;
  PaintLayer paint_layer_;
  std::optional<std::vector<OutlineSegment>> outline_;  ///< active contour; none if not read since the last image
  SlicePainter slice_painter_;
  FieldPainter field_painter_;
  OutlinePainter outline_painter_;
  LinePainter line_painter_;
  DiscPainter disc_painter_;
  MeasurementLayer measurement_layer_;
  LayerOverlay layers_;
  LandmarkOverlay landmarks_;
};

}  // namespace simplexseg
