// SPDX-License-Identifier: Apache-2.0
#include "gui/views/slice_view.h"

#include <QKeyEvent>
#include <QMouseEvent>
#include <QResizeEvent>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/expect.h"
#include "core/number_text.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/paint_outline.h"
#include "gui/views/point_wheel.h"
#include "gui/views/slice_annotations.h"
#include "gui/views/slice_hits.h"
#include "gui/workbench/workbench.h"
#include "session/paint.h"

namespace simplexseg {
namespace {

/// Whether a tool that does not paint draws a lasso while ViewState::lasso is on.
bool draws_lasso(Tool tool) { return tool == Tool::Inside || tool == Tool::Outside || tool == Tool::Box; }

}  // namespace

double handle_opacity(double distance_mm) {
  constexpr double kFarthest = 12;
  return distance_mm >= kFarthest ? 0 : 0.15 + 0.85 * (1 - distance_mm / kFarthest) * (1 - distance_mm / kFarthest);
}

SliceView::SliceView(Workbench& workbench, DrawnScene& drawn, Orientation orientation, QWidget* parent, int neighbour)
    : View(workbench, drawn, parent),
      orientation_(orientation),
      neighbour_(neighbour),
      tools_(workbench, *this),
      layers_(workbench, drawn, *this),
      landmarks_(workbench, *this) {
  set_orientation(orientation);
  connect(&workbench_, &Workbench::view_changed, this, &SliceView::update_cursor);
  connect(&workbench_, &Workbench::view_changed, this, [this] { tools_.discard_outdated_measurement(); });
  connect(&workbench_, &Workbench::scene_changed, this, [this] { tools_.update_hovered_point(); });
}

SliceView::~SliceView() { destroy_gl_objects(); }

SliceAxes SliceView::axes() const { return slice_axes(orientation_, workbench_.view.convention); }
double SliceView::slice_mm() const { return through_mm()[axes().normal]; }
Eigen::Vector3d SliceView::through_mm() const {
  if (neighbour_ == 0 || !workbench_.has_volume()) return workbench_.view.crosshair_mm;
  return slice_through_mm(workbench_.view, workbench_.session().volume().geometry(), orientation_, neighbour_);
}
double SliceView::distance_to_slice_mm(const Eigen::Vector3d& world_mm) const {
  return std::abs(world_mm[axes().normal] - slice_mm());
}

Eigen::Vector3d SliceView::world_of(const QPointF& pixel) const {
  const SliceAxes axes = this->axes();
  Eigen::Vector3d world = centre_mm_ + (pixel.x() - width() / 2.0) * mm_per_pixel_ * axes.right +
                          (height() / 2.0 - pixel.y()) * mm_per_pixel_ * axes.up;
  world[axes.normal] = slice_mm();
  return world;
}

Eigen::Vector3d SliceView::crosshair_at(const QPointF& pixel) const {
  Eigen::Vector3d at = world_of(pixel);
  at[axes().normal] = workbench_.view.crosshair_mm[axes().normal];
  return at;
}

void SliceView::set_orientation(Orientation orientation) {
  orientation_ = orientation;
  const QString title = title_of(orientation);
  setObjectName(neighbour_ == 0  ? title
                : neighbour_ < 0 ? tr("%1, previous slice").arg(title)
                                 : tr("%1, next slice").arg(title));
  setAccessibleName(tr("%1 view").arg(objectName()));
  outline_.reset();
  fit();
}

QPointF SliceView::pixel_of(const Eigen::Vector3d& world_mm) const {
  const SliceAxes axes = this->axes();
  const Eigen::Vector3d offset = (world_mm - centre_mm_) / mm_per_pixel_;
  return {width() / 2.0 + offset.dot(axes.right), height() / 2.0 - offset.dot(axes.up)};
}

std::span<const OutlineSegment> SliceView::active_outline() {
  if (!outline_) {
    outline_.emplace();
    const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
    const auto active = std::find_if(meshes.begin(), meshes.end(), [&](const MeshItem& item) {
      return item.id == workbench_.view.active_mesh && item.visible;
    });
    if (outlines_ && active != meshes.end()) {
      makeCurrent();
      outline_ = drawn_.buffers().read_outline(orientation_, static_cast<int>(active - meshes.begin()), neighbour_);
      doneCurrent();
    }
  }
  return *outline_;
}

void SliceView::fit() {
  fitted_ = true;
  if (!workbench_.has_volume()) return;
  const WorldBox box = world_box(workbench_.session().volume().geometry());
  const SliceAxes axes = this->axes();
  centre_mm_ = box.centre_mm();
  const double wide = std::abs(box.extent_mm().dot(axes.right)), high = std::abs(box.extent_mm().dot(axes.up));
  mm_per_pixel_ = 1.04 * std::max({wide / std::max(width(), 1), high / std::max(height(), 1), 1e-6});
  update();
  emit frame_changed();
}

void SliceView::centre_on_crosshair() {
  fitted_ = false;
  centre_mm_ = workbench_.view.crosshair_mm;
  update();
  emit frame_changed();
}

void SliceView::pan(const QPointF& by) {
  centre_mm_ += (by.y() * axes().up - by.x() * axes().right) * mm_per_pixel_;
  fitted_ = false;
  update();
  emit frame_changed();
}

void SliceView::zoom_about(const QPointF& pixel, double factor) {
  SIMPLEXSEG_EXPECT(workbench_.has_volume() && factor > 0);
  const WorldBox box = world_box(workbench_.session().volume().geometry());
  const Eigen::Vector3d before = world_of(pixel);
  const double coarsest = 4 * box.extent_mm().maxCoeff() / std::max(std::min(width(), height()), 1);
  mm_per_pixel_ = std::clamp(mm_per_pixel_ * factor, 1e-4 * coarsest, coarsest);
  centre_mm_ += before - world_of(pixel);
  fitted_ = false;
  update();
  emit frame_changed();
}

void SliceView::copy_frame(const SliceView& other) {
  SIMPLEXSEG_EXPECT(other.orientation_ == orientation_);
  fitted_ = other.fitted_;
  centre_mm_ = other.centre_mm_;
  mm_per_pixel_ = other.mm_per_pixel_;
  update();
}

void SliceView::move_by_slices(int slices) {
  if (!workbench_.has_volume()) return;
  const int normal = axes().normal;
  Eigen::Vector3d at = workbench_.view.crosshair_mm;
  at[normal] += slices * slice_spacing_mm(workbench_.session().volume().geometry())[normal];
  workbench_.set_crosshair(at);
}

void SliceView::resizeEvent(QResizeEvent* event) {
  View::resizeEvent(event);
  if (fitted_) fit();
}

void SliceView::create_painters() {
  slice_painter_.create();
  field_painter_.create();
  outline_painter_.create();
  line_painter_.create();
  disc_painter_.create();
  measurement_layer_.create();
  layers_.create(), landmarks_.create();
}

void SliceView::destroy_painters() {
  slice_painter_.destroy();
  field_painter_.destroy();
  outline_painter_.destroy();
  line_painter_.destroy();
  disc_painter_.destroy();
  measurement_layer_.destroy();
  layers_.destroy(), landmarks_.destroy();
}

Projection SliceView::projection() const {
  const SliceAxes axes = this->axes();
  Projection projection;
  projection.viewport_px = viewport_px();
  const double scale_x = 2 / (mm_per_pixel_ * width()), scale_y = 2 / (mm_per_pixel_ * height());
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip.row(0).head<3>() = axes.right * scale_x;
  clip.row(1).head<3>() = axes.up * scale_y;
  clip(0, 3) = -axes.right.dot(centre_mm_) * scale_x;
  clip(1, 3) = -axes.up.dot(centre_mm_) * scale_y;
  clip(3, 3) = 1;  // all depths are 0: what is drawn later covers what is drawn earlier
  projection.clip_from_world = clip.cast<float>();
  return projection;
}

void SliceView::prepare() {
  outline_.reset();
  slice_ = drawn_.slice(orientation_, neighbour_);
  layers_.prepare(slice_);
  outlines_ = workbench_.view.show_meshes ? drawn_.outlines(orientation_, neighbour_) : nullptr;
  field_ = drawn_.field();
  springs_ = &drawn_.springs();
}

void SliceView::paint() {
  const Projection projection = this->projection();
  begin_frame(projection, rgba_of(theme::kSliceBackground));
  if (!workbench_.has_volume()) return;
  const ViewState& view = workbench_.view;
  if (slice_) draw_slice(projection);
  layers_.draw(projection);
  if (slice_ && field_) draw_field(projection);
  if (outlines_) draw_outlines(projection);
  if (view.show_annotations) draw_crosshair(projection);
  draw_springs(projection);
  draw_paint(projection);
  draw_points(projection);
  draw_seed(projection);
  draw_brush(projection);
  measurement_layer_.draw(projection, workbench_, *this, tools_.measurement());
  layers_.draw_divider(projection);
  landmarks_.draw(projection);
  if (view.show_annotations) draw_scale_bar(projection);
}

void SliceView::draw_slice(const Projection& projection) {
  constexpr float kTint = 0.5f;
  const ViewState& view = workbench_.view;
  const MeshItem* const item = workbench_.active_mesh();
  if (!view.range_preview || !item) return slice_painter_.draw(projection, *slice_, true);
  const auto grey = [&](double intensity) {
    const double share = (intensity - view.level) / view.window + 0.5;
    return static_cast<float>(view.low_is_bright ? 1 - share : share);
  };
  // Grey values beyond the window are equal: those at its ends are tinted only without a limit there.
  constexpr float kStep = 1.0f / 512;
  const auto limit = [&](double intensity) {
    return std::isfinite(intensity) ? std::clamp(grey(intensity), kStep, 1 - kStep) : grey(intensity);
  };
  std::array<float, 2> tinted{limit(view.range_preview->low), limit(view.range_preview->high)};
  if (view.low_is_bright) std::swap(tinted[0], tinted[1]);
  slice_painter_.draw(projection, *slice_, true, {}, tinted, rgba_of(item->colour, kTint));
}

void SliceView::draw_field(const Projection& projection) {
  constexpr float kStrongest = 0.4f;
  const MeshItem* item = workbench_.active_mesh();
  if (item) field_painter_.draw(projection, slice_->grid, *field_, rgba_of(item->colour, kStrongest));
}

void SliceView::draw_outlines(const Projection& projection) {
  const float ratio = static_cast<float>(devicePixelRatio());
  const ViewState& view = workbench_.view;
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  constexpr float kFill = 0.3f;  // opacity of the fill of an opaque mesh
  for (std::size_t m = 0; view.show_fill && m < meshes.size(); ++m)
    if (meshes[m].visible)
      outline_painter_.fill(projection, *outlines_, static_cast<int>(m),
                            rgba_of(meshes[m].colour, kFill * meshes[m].opacity * view.opacity));
  for (const bool active : {false, true}) {  // the active contour is drawn last
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      if (!meshes[m].visible || (meshes[m].id == view.active_mesh) != active) continue;
      outline_painter_.draw(projection, *outlines_, static_cast<int>(m), rgba_of(meshes[m].colour),
                            (!active          ? 1.4f
                             : tools_.grabs() ? 3.6f
                                              : 2.4f) *
                                ratio);
    }
  }
}

// Draws the traces of the other two slices, with a gap so that the image at the crosshair stays visible.
void SliceView::draw_crosshair(const Projection& projection) {
  const SliceAxes axes = this->axes();
  const Eigen::Vector3d at = workbench_.view.crosshair_mm;
  const double reach = mm_per_pixel_ * (width() + height()) + (at - centre_mm_).norm(), gap = 7 * mm_per_pixel_;
  for (const Orientation other : kOrientations) {
    if (other == orientation_) continue;
    const int normal = slice_axes(other, Convention::Radiological).normal;
    const Eigen::Vector3d along = std::abs(axes.right[normal]) > 0.5 ? axes.up : axes.right;
    const Eigen::Vector3f ends[] = {(at - reach * along).cast<float>(), (at - gap * along).cast<float>(),
                                    (at + gap * along).cast<float>(), (at + reach * along).cast<float>()};
    line_painter_.draw(projection, ends, rgba_of(theme::slice_colour(other), 0.55f),
                       static_cast<float>(devicePixelRatio()));
  }
}

// Draws lines from boundary points to the vertices that they pull, and the reach of the point under the mouse.
void SliceView::draw_springs(const Projection& projection) {
  for (const PointSpring& spring : springs_->all()) {
    const UserPoint* point = workbench_.scene().find_point(spring.point);
    const MeshItem* item = point ? workbench_.scene().find_mesh(point->mesh) : nullptr;
    if (!item) continue;
    const auto opacity = static_cast<float>(handle_opacity(distance_to_slice_mm(point->position_mm)));
    if (opacity <= 0) continue;
    const Eigen::Vector3f ends[] = {point->position_mm.cast<float>(), spring.vertex_mm.cast<float>()};
    line_painter_.draw(projection, ends, rgba_of(item->colour, opacity), 1.6f * static_cast<float>(devicePixelRatio()));
    if (spring.point == workbench_.view.hovered_point && spring.reach_mm > 0)
      draw_circle(projection, spring.vertex_mm, spring.reach_mm, rgba_of(item->colour, 0.5f), 1.0f);
  }
}

void SliceView::draw_scale_bar(const Projection& projection) {
  const std::vector<Eigen::Vector3f> ends = scale_bar_lines(*this);
  const auto ratio = static_cast<float>(devicePixelRatio());
  line_painter_.draw(projection, ends, rgba_of(theme::kSliceBackground, 0.8f), 3.4f * ratio);
  line_painter_.draw(projection, ends, rgba_of(theme::kText), 1.4f * ratio);
}

// Draws the section of the seed sphere, or the box, while the user drags it.
void SliceView::draw_seed(const Projection& projection) {
  const std::optional<Seed>& seed = tools_.seed();
  if (seed) draw_circle(projection, seed->centre_mm, seed->radius_mm, rgba_of(theme::kSelected), 1.6f);
  const std::vector<Eigen::Vector3d> box_mm = tools_.box_mm();
  std::vector<Eigen::Vector3f> ends;
  for (std::size_t side = 0; side < box_mm.size(); ++side)
    for (const std::size_t end : {side, (side + 1) % box_mm.size()}) ends.push_back(box_mm[end].cast<float>());
  if (!ends.empty())
    line_painter_.draw(projection, ends, rgba_of(theme::kSelected), 1.6f * static_cast<float>(devicePixelRatio()));
}

void SliceView::draw_circle(const Projection& projection, const Eigen::Vector3d& centre_mm, double radius_mm,
                            const Rgba& colour, float width) {
  constexpr int kSides = 72;
  const SliceAxes axes = this->axes();
  std::vector<Eigen::Vector3f> ends;
  const auto at = [&](int side) -> Eigen::Vector3f {
    const double angle = 2 * std::numbers::pi * side / kSides;
    return (centre_mm + radius_mm * (std::cos(angle) * axes.right + std::sin(angle) * axes.up)).cast<float>();
  };
  for (int side = 0; side < kSides; ++side) {
    ends.push_back(at(side));
    ends.push_back(at(side + 1));
  }
  line_painter_.draw(projection, ends, colour, width * static_cast<float>(devicePixelRatio()));
}

QRectF SliceView::text_box() const { return QRectF(rect()).adjusted(7, 5, -7, -5); }

void SliceView::annotate(std::vector<Label>& labels) const {
  const SliceAxes axes = this->axes();
  const QRectF box = text_box();
  const auto letter = [&](const Eigen::Vector3d& direction, int alignment) {
    labels.push_back({box, alignment, QString(QChar(letter_of(direction))), theme::kText});
  };
  letter(-axes.right, Qt::AlignLeft | Qt::AlignVCenter);
  letter(axes.right, Qt::AlignRight | Qt::AlignVCenter);
  letter(axes.up, Qt::AlignHCenter | Qt::AlignTop);
  letter(-axes.up, Qt::AlignHCenter | Qt::AlignBottom);
  measurement_layer_.add_labels(labels);
  layers_.add_labels(labels, box);
  landmarks_.add_labels(labels, box);
  if (!workbench_.view.show_annotations) return;
  labels.push_back(
      {box, Qt::AlignLeft | Qt::AlignTop, slice_title(workbench_, *this), theme::slice_colour(orientation_)});
  const double bar_mm = scale_bar_mm(*this);
  labels.push_back({box.adjusted(0, 0, 0, -13), Qt::AlignRight | Qt::AlignBottom,
                    bar_mm >= 10 ? tr("%1 cm").arg(bar_mm / 10) : text(length_text(bar_mm)), theme::kText, false});
  add_names(labels, box.adjusted(0, fontMetrics().lineSpacing() + 2, 0, 0));
  QString note;
  if (underMouse() && workbench_.view.hovered_point) {
    note = point_text(workbench_, workbench_.view.hovered_point);
  } else if (tools_.seed()) {
    note = tr("radius %1").arg(text(length_text(tools_.seed()->radius_mm)));
  } else if (tools_.brush_centre_mm()) {
    note = brush_text();
  } else if (underMouse() && draws_lasso(workbench_.view.tool) && workbench_.view.lasso) {
    note = workbench_.view.tool == Tool::Box ? tr("lasso around a new structure") : tr("lasso");
  } else if (workbench_.view.window_level_armed) {
    note = tr("window %1  level %2").arg(workbench_.view.window, 0, 'g', 4).arg(workbench_.view.level, 0, 'g', 4);
  } else if (const MeshItem* item = workbench_.active_mesh(); workbench_.view.show_field && !field_ && item) {
    note = tr("no probability field yet: '%1'").arg(QString::fromStdString(item->name));
  }
  if (!note.isEmpty()) labels.push_back({box, Qt::AlignLeft | Qt::AlignBottom, note, theme::kSelected, false});
}

void SliceView::mousePressEvent(QMouseEvent* event) {
  if (!landmarks_.press(*event) && !layers_.press(*event)) tools_.press(*event);
}
void SliceView::mouseMoveEvent(QMouseEvent* event) {
  if (!layers_.move(*event)) tools_.move(*event);
}
void SliceView::mouseReleaseEvent(QMouseEvent* event) {
  if (!layers_.release(*event)) tools_.release(*event);
}

void SliceView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (!tools_.double_click(*event)) emit maximise_requested();
}

void SliceView::wheelEvent(QWheelEvent* event) {
  tools_.wheel(*event);
  event->accept();
}

// A measurement that is being drawn is cancelled by the key of a menu entry.
bool SliceView::event(QEvent* event) {
  if (event->type() == QEvent::ShortcutOverride && tools_.uses_key(*static_cast<QKeyEvent*>(event))) event->accept();
  return View::event(event);
}

void SliceView::keyPressEvent(QKeyEvent* event) {
  if (!tools_.key(*event)) View::keyPressEvent(event);
}

void SliceView::leaveEvent(QEvent* event) {
  tools_.leave();
  layers_.leave();
  View::leaveEvent(event);
}

void SliceView::update_cursor() {
  const ViewState& view = workbench_.view;
  if (view.window_level_armed || view.layer_contrast_armed) {
    setCursor(Qt::SizeAllCursor);
  } else if (layers_.is_on_divider()) {
    setCursor(Qt::SplitHCursor);
  } else if (view.landmarks.next != LandmarkInput::Next::None) {
    setCursor(Qt::CrossCursor);
  } else if (view.hovered_point || view.hovered_measurement) {
    setCursor(Qt::PointingHandCursor);
  } else if (view.tool == Tool::ZoomPan) {
    setCursor(Qt::OpenHandCursor);
  } else if (view.tool == Tool::Crosshair) {
    setCursor(tools_.grabs() ? Qt::OpenHandCursor : Qt::ArrowCursor);
  } else {
    setCursor(Qt::CrossCursor);
  }
}

}  // namespace simplexseg
