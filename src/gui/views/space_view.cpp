// SPDX-License-Identifier: Apache-2.0
#include "gui/views/space_view.h"

#include <QMouseEvent>
#include <QWheelEvent>
#include <cmath>

#include "gui/look/theme.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/picking.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

SpaceView::SpaceView(Workbench& workbench, DrawnScene& drawn, QWidget* parent) : View(workbench, drawn, parent) {
  setObjectName("3D");
  // Slices need no multisampling: their lines are smooth by themselves.
  QSurfaceFormat smooth = format();
  smooth.setSamples(2);
  setFormat(smooth);
}

SpaceView::~SpaceView() { destroy_gl_objects(); }

void SpaceView::fit() {
  if (!workbench_.has_volume()) return;
  const WorldBox box = world_box(workbench_.session().volume().geometry());
  camera_.fit(box.centre_mm(), box.extent_mm().norm() / 2);
  update();
}

void SpaceView::centre_on_crosshair() {
  camera_.look_at(workbench_.view.crosshair_mm);
  update();
}

void SpaceView::create_painters() {
  slice_painter_.create();
  line_painter_.create();
  disc_painter_.create();
  mesh_painter_.create();
}

void SpaceView::destroy_painters() {
  slice_painter_.destroy();
  line_painter_.destroy();
  disc_painter_.destroy();
  mesh_painter_.destroy();
}

double SpaceView::aspect() const { return static_cast<double>(std::max(width(), 1)) / std::max(height(), 1); }

Projection SpaceView::projection() const {
  const Eigen::Matrix4d eye = camera_.eye_from_world();
  return {(camera_.clip_from_eye(aspect()) * eye).cast<float>(), eye.cast<float>(), viewport_px()};
}

void SpaceView::prepare() {
  const ViewState& view = workbench_.view;
  for (const Orientation orientation : kOrientations) {
    slices_[static_cast<int>(orientation)] = view.show_slices_3d ? drawn_.slice(orientation) : nullptr;
  }
  surfaces_ = view.show_meshes ? drawn_.surfaces() : nullptr;
}

void SpaceView::paint() {
  const Projection projection = this->projection();
  begin_frame(projection, rgba_of(theme::kSpaceBackground));
  if (!workbench_.has_volume()) return;
  set_depth(Depth::Test);
  draw_slices(projection);
  if (surfaces_) draw_meshes(projection);
  // Last, as their smooth edges are half transparent and yet would hide what comes later.
  if (workbench_.view.show_slices_3d) draw_frames(projection);
  draw_points(projection);
  set_depth(Depth::Ignore);
}

void SpaceView::draw_slices(const Projection& projection) {
  for (const SceneBuffers::Slice* slice : slices_) {
    if (slice) slice_painter_.draw(projection, *slice, false);
  }
}

void SpaceView::draw_frames(const Projection& projection) {
  const VolumeGeometry& geometry = workbench_.session().volume().geometry();
  for (const Orientation orientation : kOrientations) {
    const SliceGrid grid = slice_grid(geometry, orientation, workbench_.view.crosshair_mm);
    const Eigen::Vector3d corner = grid.corner_mm();
    const Eigen::Vector3d u = grid.step_u_mm * grid.width, v = grid.step_v_mm * grid.height;
    const Eigen::Vector3d corners[] = {corner, corner + u, corner + u + v, corner + v};
    std::vector<Eigen::Vector3f> frame;
    for (int side = 0; side < 4; ++side) {
      frame.push_back(corners[side].cast<float>());
      frame.push_back(corners[(side + 1) % 4].cast<float>());
    }
    line_painter_.draw(projection, frame, rgba_of(theme::slice_colour(orientation), 0.8f),
                       1.2f * static_cast<float>(devicePixelRatio()));
  }
}

void SpaceView::draw_meshes(const Projection& projection) {
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    if (!meshes[m].visible) continue;
    mesh_painter_.draw(projection, *surfaces_, static_cast<int>(m),
                       rgba_of(meshes[m].colour, meshes[m].opacity * workbench_.view.opacity));
  }
}

void SpaceView::draw_points(const Projection& projection) {
  std::vector<DiscPainter::Disc> discs;
  for (const UserPoint& point : workbench_.scene().points) {
    const MeshItem* item = workbench_.scene().find_mesh(point.mesh);
    if (!item) continue;
    const Rgba rim = point.id == workbench_.view.selected_point ? rgba_of(theme::kSelected) : Rgba(1, 1, 1, 1);
    discs.push_back({point.position_mm.cast<float>(), rgba_of(colour_of(point.kind, item->colour)), rim,
                     5.0f * static_cast<float>(devicePixelRatio()), glyph_of(point.kind)});
  }
  disc_painter_.draw(projection, discs);
}

void SpaceView::annotate(std::vector<Label>& labels) const {
  if (!workbench_.view.show_annotations) return;
  const QRectF box = QRectF(rect()).adjusted(7, 5, -7, -5);
  labels.push_back({box, Qt::AlignLeft | Qt::AlignTop, tr("3D"), theme::kText});
  // The patient's sides, at the ends of the crosshair's axes.
  const WorldBox world = world_box(workbench_.session().volume().geometry());
  const Eigen::Matrix4f clip_from_world = projection().clip_from_world;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d direction = side * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector3d at = world.centre_mm() + 0.56 * direction.cwiseProduct(world.extent_mm());
      const Eigen::Vector4f clip = clip_from_world * at.cast<float>().homogeneous();
      if (clip.w() <= 0) continue;
      const QPointF pixel((clip.x() / clip.w() * 0.5 + 0.5) * width(), (0.5 - clip.y() / clip.w() * 0.5) * height());
      labels.push_back({QRectF(pixel - QPointF(10, 10), QSizeF(20, 20)), Qt::AlignCenter,
                        QString(QChar(letter_of(direction))), theme::kDimText});
    }
  }
}

void SpaceView::mousePressEvent(QMouseEvent* event) {
  last_ = event->position();
  Mouse mouse = Mouse::Middle;
  if (event->button() == Qt::LeftButton) mouse = Mouse::Left;
  if (event->button() == Qt::RightButton) mouse = Mouse::Right;
  drag_ = gesture(Where::Space, mouse, event->modifiers());
  if (drag_ == Act::PickMesh) pick(event->position());
}

void SpaceView::mouseMoveEvent(QMouseEvent* event) {
  const QPointF moved = event->position() - last_;
  last_ = event->position();
  if (!drag_) return;
  constexpr double kRadiansPerPixel = 0.008;
  switch (*drag_) {
    case Act::Rotate:
      camera_.rotate(moved.x() * kRadiansPerPixel, moved.y() * kRadiansPerPixel);
      break;
    case Act::Pan:
      camera_.pan(moved.x(), moved.y(), height());
      break;
    case Act::Zoom:
      camera_.zoom(std::exp(moved.y() * 0.01));
      break;
    default:
      return;
  }
  update();
}

void SpaceView::mouseReleaseEvent(QMouseEvent*) { drag_.reset(); }

void SpaceView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton &&
      gesture(Where::Space, Mouse::DoubleClick, event->modifiers()) == Act::Maximise) {
    emit maximise_wanted();
  }
}

void SpaceView::wheelEvent(QWheelEvent* event) {
  if (gesture(Where::Space, Mouse::Wheel, event->modifiers()) == Act::WheelZoom) {
    camera_.zoom(std::exp(-event->angleDelta().y() / 120.0 * 0.12));
    update();
  }
  event->accept();
}

void SpaceView::pick(const QPointF& pixel) {
  const OrbitCamera::Ray ray = camera_.ray(2 * pixel.x() / width() - 1, 1 - 2 * pixel.y() / height(), aspect());
  ItemId hit = 0;
  double nearest = INFINITY;
  for (const Surface& surface : visible_surfaces(workbench_.session().scene())) {
    const std::optional<double> distance = hit_surface(surface.shape, ray.origin_mm, ray.direction);
    if (distance && *distance < nearest) {
      nearest = *distance;
      hit = surface.mesh;
    }
  }
  if (hit) workbench_.set_active_mesh(hit);
}

}  // namespace simplexseg
