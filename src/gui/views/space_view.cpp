// SPDX-License-Identifier: Apache-2.0
#include "gui/views/space_view.h"

#include <QMouseEvent>
#include <QWheelEvent>
#include <cmath>
#include <numbers>

#include "gui/look/theme.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/picking.h"
#include "gui/workbench/workbench.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {

SpaceView::SpaceView(Workbench& workbench, DrawnScene& drawn, QWidget* parent)
    : View(workbench, drawn, parent), point_wheel_(workbench), solids_(workbench, drawn), plane_handle_(workbench) {
  setObjectName("3D");
  // Slice views need no multisampling: their lines are antialiased by the shader.
  QSurfaceFormat smooth = format();
  smooth.setSamples(2);
  setFormat(smooth);
  late_.setSingleShot(true);
  connect(&late_, &QTimer::timeout, this, qOverload<>(&QWidget::update));
}

SpaceView::~SpaceView() { destroy_gl_objects(); }

void SpaceView::show_progress() {
  constexpr int kLeastMs = 100;
  const qint64 passed_ms = since_paint_.isValid() ? since_paint_.elapsed() : kLeastMs;
  if (passed_ms >= kLeastMs || !is_software_)
    update();
  else if (!late_.isActive())
    late_.start(static_cast<int>(kLeastMs - passed_ms));
}

void SpaceView::fit() {
  if (!workbench_.has_volume()) return;
  const WorldBox box = world_box(workbench_.session().volume().geometry());
  camera_.fit(box.centre_mm(), box.extent_mm().norm() / 2);
  update();
  emit camera_changed();
}

void SpaceView::centre_on_crosshair() {
  camera_.set_target(workbench_.view.crosshair_mm);
  update();
  emit camera_changed();
}

void SpaceView::copy_camera(const SpaceView& other) {
  camera_ = other.camera_;
  update();
}

void SpaceView::create_painters() {
  slice_painter_.create();
  line_painter_.create();
  disc_painter_.create();
  solids_.create();
  is_software_ = is_software_renderer();
}

void SpaceView::destroy_painters() {
  slice_painter_.destroy();
  line_painter_.destroy();
  disc_painter_.destroy();
  solids_.destroy();
}

double SpaceView::aspect() const { return static_cast<double>(std::max(width(), 1)) / std::max(height(), 1); }

ScreenMap SpaceView::map() const { return {camera_, {std::max(width(), 1) * 1.0, std::max(height(), 1) * 1.0}}; }

Projection SpaceView::projection() const {
  const Eigen::Matrix4d eye = camera_.eye_from_world();
  return {(camera_.clip_from_eye(aspect()) * eye).cast<float>(), eye.cast<float>(), viewport_px()};
}

void SpaceView::prepare() {
  const ViewState& view = workbench_.view;
  for (const Orientation orientation : kOrientations) {
    slices_[static_cast<int>(orientation)] = view.show_slices_3d ? drawn_.slice(orientation) : nullptr;
  }
  solids_.prepare();
  springs_ = &drawn_.springs();
}

void SpaceView::paint() {
  since_paint_.start();
  const Projection projection = this->projection();
  begin_frame(projection, rgba_of(theme::kSpaceBackground));
  if (!workbench_.has_volume()) return;
  set_depth(Depth::Test);
  draw_slices(projection);
  solids_.draw(projection, map().eye_mm());
  // Lines and points are drawn last: their edges are partly transparent, but their depth hides what is drawn later.
  if (workbench_.view.show_slices_3d) draw_frames(projection);
  draw_springs(projection);
  draw_points(projection);
  plane_handle_.draw(projection, map(), devicePixelRatio(), line_painter_, disc_painter_);
  set_depth(Depth::Ignore);
  if (solids_.coloured()) draw_scale(projection);
}

void SpaceView::draw_slices(const Projection& projection) {
  for (const Orientation orientation : kOrientations) {
    const auto n = static_cast<int>(orientation);
    if (slices_[n])
      slice_painter_.draw(projection, *slices_[n], false, solids_.equations_except(static_cast<CutPlane>(n)));
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

void SpaceView::draw_points(const Projection& projection) {
  std::vector<DiscPainter::Disc> discs;
  for (const UserPoint& point : workbench_.scene().points) {
    const MeshItem* item = workbench_.scene().find_mesh(point.mesh);
    if (!item || point.is_paint()) continue;
    draw_stroke(projection, point, rgba_of(colour_of(point.kind, item->colour)));
    if (is_clipped(solids_.planes(), point.position_mm)) continue;
    const bool selected = point.id == workbench_.view.selected_point,
               hovered = point.id == workbench_.view.hovered_point;
    const Rgba rim = selected ? rgba_of(theme::kSelected) : Rgba(1, 1, 1, 1);
    discs.push_back({point.position_mm.cast<float>(), rgba_of(colour_of(point.kind, item->colour)), rim,
                     (hovered ? 7.5f : 6.0f) * static_cast<float>(devicePixelRatio()), glyph_of(point.kind)});
    if (point.kind != MarkKind::Boundary && (selected || hovered))
      draw_circle(projection, point.position_mm, point.radius_mm, rgba_of(item->colour, 0.9f));
  }
  disc_painter_.draw(projection, discs);
}

void SpaceView::draw_stroke(const Projection& projection, const UserPoint& point, const Rgba& colour) {
  if (!point.is_stroke()) return;
  const std::vector<Eigen::Vector3d> vertices = point.vertices_mm();
  std::vector<Eigen::Vector3f> ends;
  for (std::size_t p = 1; p < vertices.size(); ++p) {
    ends.push_back(vertices[p - 1].cast<float>());
    ends.push_back(vertices[p].cast<float>());
  }
  if (point.is_lasso())
    for (const Eigen::Vector3d& end : {vertices.back(), vertices.front()}) ends.push_back(end.cast<float>());
  line_painter_.draw(projection, clip_segments(solids_.planes(), std::move(ends)), colour,
                     3.0f * static_cast<float>(devicePixelRatio()));
}

void SpaceView::draw_springs(const Projection& projection) {
  const auto ratio = static_cast<float>(devicePixelRatio());
  std::vector<DiscPainter::Disc> ends;
  for (const PointSpring& spring : springs_->all()) {
    const UserPoint* point = workbench_.scene().find_point(spring.point);
    const MeshItem* item = point ? workbench_.scene().find_mesh(point->mesh) : nullptr;
    if (!item || is_clipped(solids_.planes(), point->position_mm) ||
        is_clipped(solids_.planes(), spring.vertex_mm.cast<double>()))
      continue;
    const Eigen::Vector3f line[] = {point->position_mm.cast<float>(), spring.vertex_mm.cast<float>()};
    line_painter_.draw(projection, line, Rgba(1, 1, 1, 0.9f), 2.0f * ratio);
    ends.push_back({line[1], Rgba(1, 1, 1, 1), rgba_of(item->colour), 3.0f * ratio});
    if (spring.point == workbench_.view.hovered_point && spring.reach_mm > 0)
      draw_circle(projection, spring.vertex_mm, spring.reach_mm, Rgba(1, 1, 1, 0.6f));
  }
  disc_painter_.draw(projection, ends);
}

void SpaceView::draw_circle(const Projection& projection, const Eigen::Vector3d& centre_mm, double radius_mm,
                            const Rgba& colour) {
  constexpr int kSides = 48;
  const Eigen::Matrix4d eye = camera_.eye_from_world();
  const Eigen::Vector3d right = eye.row(0).head<3>(), up = eye.row(1).head<3>();
  std::vector<Eigen::Vector3f> ends;
  const auto at = [&](int side) -> Eigen::Vector3f {
    const double angle = 2 * std::numbers::pi * side / kSides;
    return (centre_mm + radius_mm * (std::cos(angle) * right + std::sin(angle) * up)).cast<float>();
  };
  for (int side = 0; side < kSides; ++side) {
    ends.push_back(at(side));
    ends.push_back(at(side + 1));
  }
  set_depth(Depth::Ignore);
  line_painter_.draw(projection, ends, colour, 1.4f * static_cast<float>(devicePixelRatio()));
  set_depth(Depth::Test);
}

QRectF SpaceView::scale_box() const { return {width() - 24.0, 0.2 * height(), 12.0, 0.55 * height()}; }

// Draws the colour scale, in logical pixels of the view.
void SpaceView::draw_scale(const Projection& projection) {
  Projection pixels;
  pixels.viewport_px = projection.viewport_px;
  pixels.clip_from_world.setIdentity();
  pixels.clip_from_world(0, 0) = 2.0f / static_cast<float>(width());
  pixels.clip_from_world(1, 1) = -2.0f / static_cast<float>(height());
  pixels.clip_from_world(0, 3) = -1;
  pixels.clip_from_world(1, 3) = 1;
  const QRectF box = scale_box();
  constexpr int kBands = 32;
  const auto x = static_cast<float>(box.center().x());
  for (int band = 0; band < kBands; ++band) {
    const auto y = [&](int edge) { return static_cast<float>(box.bottom() - box.height() * edge / kBands); };
    const Eigen::Vector3f ends[] = {{x, y(band), 0}, {x, y(band + 1), 0}};
    const std::array<float, 3> colour = scale_colour((static_cast<float>(band) + 0.5f) / kBands);
    line_painter_.draw(pixels, ends, Rgba(colour[0], colour[1], colour[2], 1),
                       static_cast<float>(box.width() * devicePixelRatio()));
  }
}

void SpaceView::annotate(std::vector<Label>& labels) const {
  if (!workbench_.view.show_annotations) return;
  const QRectF box = QRectF(rect()).adjusted(7, 5, -7, -5);
  labels.push_back({box, Qt::AlignLeft | Qt::AlignTop, tr("3D"), theme::kText});
  if (solids_.coloured()) {
    const QRectF scale = scale_box();
    const SurfaceValues& values = *workbench_.view.surface_values;
    const QRectF beside(0, scale.top() - 24, scale.right(), scale.height() + 48);
    labels.push_back({beside.adjusted(0, -16, 0, 0), Qt::AlignRight | Qt::AlignTop, values.title, theme::kText, false});
    labels.push_back({beside, Qt::AlignRight | Qt::AlignTop, tr("%1 mm").arg(values.most_mm), theme::kText, false});
    labels.push_back({beside, Qt::AlignRight | Qt::AlignBottom, tr("0 mm"), theme::kText, false});
  }
  if (const ItemId point = workbench_.view.hovered_point; point != 0 && underMouse())
    labels.push_back({box, Qt::AlignLeft | Qt::AlignBottom, point_text(workbench_, point), theme::kSelected, false});
  // Letters of the patient's sides, at the ends of the axes.
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
  last_ = press_ = event->position();
  Mouse mouse = Mouse::Middle;
  if (event->button() == Qt::LeftButton) mouse = Mouse::Left;
  if (event->button() == Qt::RightButton) mouse = Mouse::Right;
  drag_ = gesture(Where::Space, mouse, event->modifiers());
  if (drag_ == Act::PickMesh) pick(event->position());
  if (drag_ == Act::Rotate && plane_handle_.press(map(), event->position())) {
    drag_.reset();
    return;
  }
  dragged_point_ = drag_ == Act::Rotate ? point_at(event->position()) : 0;
  if (dragged_point_ == 0) return;
  drag_.reset();
  drag_continues_ = false;
  workbench_.view.selected_point = dragged_point_;
  workbench_.view_edited();
}

void SpaceView::mouseMoveEvent(QMouseEvent* event) {
  const QPointF moved = event->position() - last_;
  last_ = event->position();
  if (plane_handle_.is_dragged()) {
    plane_handle_.drag(map(), last_);
    return;
  }
  if (dragged_point_ != 0) {
    constexpr double kDragStarts = 3;  // shortest drag, logical pixels; a click selects the point
    if (drag_continues_ || (last_ - press_).manhattanLength() >= kDragStarts) drag_point(last_);
    return;
  }
  if (!drag_) {
    if (event->buttons() == Qt::NoButton) hover(last_);
    return;
  }
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
  emit camera_changed();
}

void SpaceView::mouseReleaseEvent(QMouseEvent*) {
  drag_.reset();
  dragged_point_ = 0;
  plane_handle_.release();
}

void SpaceView::leaveEvent(QEvent* event) {
  if (plane_handle_.leave()) update();
  if (workbench_.view.hovered_point != 0 && dragged_point_ == 0) {
    workbench_.view.hovered_point = 0;
    workbench_.view_edited();
  }
  View::leaveEvent(event);
}

void SpaceView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton &&
      gesture(Where::Space, Mouse::DoubleClick, event->modifiers()) == Act::Maximise) {
    emit maximise_requested();
  }
}

void SpaceView::wheelEvent(QWheelEvent* event) {
  if (plane_handle_.part_at(map(), event->position()) != FreePlaneHandle::Part::None) {
    plane_handle_.move(event->angleDelta().y() / 120.0 *
                       workbench_.session().volume().geometry().spacing_mm.minCoeff());
    event->accept();
    return;
  }
  const ItemId point = point_at(event->position());
  if (point_wheel_.handles(point) && gesture(Where::Space, Mouse::WheelOnPoint, event->modifiers())) {
    point_wheel_.turn(point, *event, false);
    event->accept();
    return;
  }
  point_wheel_.record_other_use();
  if (gesture(Where::Space, Mouse::Wheel, event->modifiers()) == Act::WheelZoom) {
    camera_.zoom(std::exp(-event->angleDelta().y() / 120.0 * 0.12));
    update();
    emit camera_changed();
  }
  event->accept();
}

ItemId SpaceView::point_at(const QPointF& pixel) const {
  constexpr double kHitRadius = 9;  // largest distance of a hit on a handle, logical pixels
  const UserPoint* nearest = nullptr;
  double best = kHitRadius;
  for (const UserPoint& point : workbench_.scene().points) {
    if (point.is_paint() || is_clipped(solids_.planes(), point.position_mm)) continue;
    const std::optional<QPointF> at = map().pixel(point.position_mm);
    const double distance = at ? std::hypot(at->x() - pixel.x(), at->y() - pixel.y()) : kHitRadius + 1;
    if (distance <= best) best = distance, nearest = &point;
  }
  if (!nearest || !workbench_.view.show_meshes) return nearest ? nearest->id : 0;
  // Points behind an opaque mesh are hidden.
  const ItemId id = nearest->id;
  const Eigen::Vector3d at = nearest->position_mm;
  const OrbitCamera::Ray ray = map().ray(*map().pixel(at));
  const double away = (at - ray.origin_mm).norm() * (1 - 1e-3) - 0.5;
  const RayRange range = kept_range(solids_.planes(), ray.origin_mm, ray.direction);
  for (const Surface& surface : visible_surfaces(workbench_.session().scene())) {
    const MeshItem* item = workbench_.scene().find_mesh(surface.mesh);
    if (item->opacity * workbench_.view.opacity < 1) continue;
    const std::optional<double> distance = hit_surface(surface.shape, ray.origin_mm, ray.direction, range);
    if (distance && *distance < away) return 0;
  }
  return id;
}

void SpaceView::hover(const QPointF& pixel) {
  const bool handle_changed = plane_handle_.hover(map(), pixel);
  const bool on_handle = plane_handle_.hovered() != FreePlaneHandle::Part::None;
  const ItemId under = on_handle ? 0 : point_at(pixel);
  if (under == workbench_.view.hovered_point && !handle_changed) return;
  workbench_.view.hovered_point = under;
  setCursor(on_handle ? Qt::SizeAllCursor : under ? Qt::PointingHandCursor : Qt::ArrowCursor);
  workbench_.view_edited();
}

// Moves the point in the plane through it that is parallel to the screen.
void SpaceView::drag_point(const QPointF& pixel) {
  const UserPoint* point = workbench_.scene().find_point(dragged_point_);
  if (!point) return;
  const Eigen::Vector3d towards = camera_.eye_from_world().row(2).head<3>();
  const auto on_plane = [&](const QPointF& at) -> Eigen::Vector3d {
    const OrbitCamera::Ray ray = map().ray(at);
    const double along = (point->position_mm - ray.origin_mm).dot(towards) / ray.direction.dot(towards);
    return ray.origin_mm + along * ray.direction;
  };
  if (!drag_continues_) grab_offset_mm_ = point->position_mm - on_plane(press_);
  const Eigen::Vector3d to = on_plane(pixel) + grab_offset_mm_;
  if (workbench_.apply(MovePoint{dragged_point_, to, drag_continues_}))
    drag_continues_ = true;
  else if (is_locked(workbench_.scene(), dragged_point_))
    dragged_point_ = 0;  // one message per drag
}

void SpaceView::pick(const QPointF& pixel) {
  const OrbitCamera::Ray ray = map().ray(pixel);
  const RayRange range = kept_range(solids_.planes(), ray.origin_mm, ray.direction);
  const std::vector<MeshItem>& meshes = workbench_.session().scene().meshes;
  ItemId hit = 0;
  double nearest = INFINITY;
  // Smaller meshes last: they are drawn over the cut faces of larger ones.
  for (const int m : solids_.largest_first()) {
    const MeshItem& item = meshes[static_cast<std::size_t>(m)];
    const std::optional<double> distance = hit_surface(tessellate(item.mesh), ray.origin_mm, ray.direction, range);
    if (distance && *distance <= nearest) {
      nearest = *distance;
      hit = item.id;
    }
  }
  if (hit) workbench_.set_active_mesh(hit);
}

}  // namespace simplexseg
