// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "gui/input/bindings.h"
#include "gui/look/slice_geometry.h"
#include "gui/views/orbit_camera.h"
#include "gui/views/view.h"

namespace simplexseg {

/// The meshes, the three slices and the points in space.
class SpaceView : public View {
  Q_OBJECT
 public:
  SpaceView(Workbench& workbench, DrawnScene& drawn, QWidget* parent);
  ~SpaceView() override;

  void fit() override;
  void centre_on_crosshair() override;

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

 private:
  Projection projection() const;
  double aspect() const;
  void draw_slices(const Projection& projection);
  void draw_frames(const Projection& projection);
  void draw_meshes(const Projection& projection);
  void draw_points(const Projection& projection);
  void pick(const QPointF& pixel);

  OrbitCamera camera_;
  std::optional<Act> drag_;
  QPointF last_;
  const SceneBuffers::Slice* slices_[3] = {};  ///< what prepare() found, like the next
  const SceneBuffers* surfaces_ = nullptr;
  SlicePainter slice_painter_;
  LinePainter line_painter_;
  DiscPainter disc_painter_;
  MeshPainter mesh_painter_;
};

}  // namespace simplexseg
