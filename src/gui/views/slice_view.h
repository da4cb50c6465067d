// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "gui/look/slice_geometry.h"
#include "gui/views/slice_tools.h"
#include "gui/views/view.h"

namespace simplexseg {

class PointSprings;

/// How visible a handle is at some distance from the slice: 1 on it, 0 where it is neither drawn nor hit.
double handle_opacity(double distance_mm);

/// One slice through the crosshair with all that lies on it. SliceTools knows what mouse and keys do there.
class SliceView : public View {
  Q_OBJECT
 public:
  SliceView(Workbench& workbench, DrawnScene& drawn, Orientation orientation, QWidget* parent);
  ~SliceView() override;

  void fit() override;
  void centre_on_crosshair() override;
  /// Moves what is shown by a drag of so many logical pixels.
  void pan(const QPointF& by);
  /// Makes a pixel `factor` times as large in the patient frame, within bounds; what lies under `pixel` stays there.
  /// There must be a volume.
  void zoom_about(const QPointF& pixel, double factor);
  /// Shows the same place at the same size as another view of that orientation.
  void frame_as(const SliceView& other);
  /// Moves the crosshair by whole slices.
  void move_by_slices(int slices);

  SliceAxes axes() const;
  /// Where the slice lies along its normal.
  double slice_mm() const;
  double distance_to_slice_mm(const Eigen::Vector3d& world_mm) const;
  /// Between widget coordinates (logical pixels) and the plane of the slice.
  Eigen::Vector3d world_of(const QPointF& pixel) const;
  QPointF pixel_of(const Eigen::Vector3d& world_mm) const;
  double mm_per_pixel() const { return mm_per_pixel_; }
  /// The pieces of the active mesh's outline in the last picture; none while meshes are hidden. Read back once for each
  /// picture, when asked for.
  std::span<const OutlinePiece> active_outline();
  /// Shows the pointer of what a press would begin.
  void update_cursor();

 signals:
  /// Zoomed, panned, fitted or centred by the user; not by frame_as().
  void framed();

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
  Projection projection() const;
  void draw_field(const Projection& projection);
  void draw_outlines(const Projection& projection);
  void draw_crosshair(const Projection& projection);
  void draw_points(const Projection& projection);
  void draw_springs(const Projection& projection);
  void draw_scale_bar(const Projection& projection);
  void draw_balls(const Projection& projection);
  /// `width`: of the line, logical pixels.
  void draw_circle(const Projection& projection, const Eigen::Vector3d& centre_mm, double radius_mm, const Rgba& colour,
                   float width);
  void draw_seed(const Projection& projection);
  /// A round length that takes about a fifth of the view.
  double scale_bar_mm() const;
  QString corner_text() const;
  QRectF text_box() const;

  const Orientation orientation_;
  Eigen::Vector3d centre_mm_{0, 0, 0};  ///< what lies in the middle of the widget
  double mm_per_pixel_ = 1;             ///< a logical pixel
  bool fitted_ = true;                  ///< follows the size of the widget until zoomed or panned
  SliceTools tools_;

  const SceneBuffers::Slice* slice_ = nullptr;  ///< what prepare() found, like the next
  const SceneBuffers::Outlines* outlines_ = nullptr;
  const SceneBuffers::Field* field_ = nullptr;
  const PointSprings* springs_ = nullptr;
  std::optional<std::vector<OutlinePiece>> outline_;  ///< of the active mesh; none: not read since the last picture
  SlicePainter slice_painter_;
  FieldPainter field_painter_;
  OutlinePainter outline_painter_;
  LinePainter line_painter_;
  DiscPainter disc_painter_;
};

}  // namespace simplexseg
