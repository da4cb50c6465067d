// SPDX-License-Identifier: Apache-2.0
#include "gui/views/view.h"

#include "core/expect.h"
#include "gui/input/focus_return.h"
#include "gui/look/theme.h"
#include "gui/views/drawn_scene.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

View::View(Workbench& workbench, DrawnScene& drawn, QWidget* parent)
    : QOpenGLWidget(parent), workbench_(workbench), drawn_(drawn) {
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setMinimumSize(160, 120);
  const auto repaint = [this] { update(); };
  connect(&workbench_, &Workbench::scene_changed, this, repaint);
  connect(&workbench_, &Workbench::pose_changed, this, &View::show_progress);
  // A running simulation shows the point in its next frame; an extra repaint would delay that frame.
  connect(&workbench_, &Workbench::point_moved, this, [this] {
    if (!workbench_.running()) update();
  });
  connect(&workbench_, &Workbench::view_changed, this, repaint);
  connect(&workbench_, &Workbench::solving_changed, this, &View::show_progress);
  connect(&workbench_, &Workbench::volume_changed, this, [this] { fit(); });
}

View::~View() { SIMPLEXSEG_EXPECT(!ready_); }

void View::destroy_gl_objects() {
  if (!ready_) return;
  makeCurrent();
  destroy_painters();
  label_painter_.destroy();
  drawn_.buffers().detach(this);
  doneCurrent();
  ready_ = false;
}

Eigen::Vector2f View::viewport_px() const {
  const double ratio = devicePixelRatio();
  return {static_cast<float>(width() * ratio), static_cast<float>(height() * ratio)};
}

void View::add_names(std::vector<Label>& labels, const QRectF& box) const {
  if (!workbench_.view.show_names) return;
  QRectF line = box;
  for (const QString& name : {workbench_.patient_name(), workbench_.series_name()}) {
    if (name.isEmpty()) continue;
    const QString fitting = fontMetrics().elidedText(name, Qt::ElideRight, static_cast<int>(0.45 * box.width()));
    labels.push_back({line, Qt::AlignLeft | Qt::AlignTop, fitting, theme::kDimText, false});
    line.adjust(0, fontMetrics().lineSpacing(), 0, 0);
  }
}

void View::initializeGL() {
  try {
    load_gl();
    create_painters();
    label_painter_.create();
    drawn_.buffers().attach(this);
    ready_ = true;
  } catch (const std::exception& error) {
    workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
  }
}

void View::paintGL() {
  if (!ready_) return;
  emit about_to_paint();
  if (workbench_.has_volume()) prepare();
  drawn_.buffers().begin_reading();
  paint();
  std::vector<Label> labels;
  if (workbench_.has_volume()) annotate(labels);
  const double ratio = devicePixelRatio();
  label_painter_.draw(size() * ratio, ratio, font(), labels);
  end_frame();
  drawn_.buffers().end_reading(this);
}

// Keys act in the view under the mouse, unless the user is typing.
void View::enterEvent(QEnterEvent* event) {
  if (!is_typing()) setFocus(Qt::MouseFocusReason);
  QOpenGLWidget::enterEvent(event);
}

}  // namespace simplexseg
