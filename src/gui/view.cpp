// SPDX-License-Identifier: Apache-2.0
#include "gui/view.h"

#include <QAbstractSpinBox>
#include <QApplication>
#include <QLineEdit>
#include <QOpenGLPaintDevice>
#include <QPainter>

#include "gui/theme.h"
#include "gui/workbench.h"

namespace simplexseg {

View::View(Workbench& workbench, QWidget* parent) : QOpenGLWidget(parent), workbench_(workbench) {
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setMinimumSize(160, 120);
  const auto repaint = [this] { update(); };
  connect(&workbench_, &Workbench::scene_changed, this, repaint);
  connect(&workbench_, &Workbench::pose_changed, this, repaint);
  connect(&workbench_, &Workbench::view_changed, this, repaint);
  connect(&workbench_, &Workbench::volume_changed, this, [this] { fit(); });
}

View::~View() = default;

void View::release() {
  if (!ready_) return;
  makeCurrent();
  destroy_painters();
  doneCurrent();
  ready_ = false;
}

Eigen::Vector2f View::viewport_px() const {
  const double ratio = devicePixelRatio();
  return {static_cast<float>(width() * ratio), static_cast<float>(height() * ratio)};
}

void View::initializeGL() {
  try {
    load_gl();
    create_painters();
    ready_ = true;
  } catch (const std::exception& error) {
    workbench_.say(Severity::Failure, QString::fromUtf8(error.what()));
  }
}

void View::paintGL() {
  if (!ready_) return;
  paint();
  end_frame();
  // Not QPainter(this): while the window is grabbed that one would draw into the picture, under the view.
  QOpenGLPaintDevice device(size() * devicePixelRatio());
  device.setDevicePixelRatio(devicePixelRatio());
  QPainter painter(&device);
  painter.setFont(font());
  painter.setRenderHint(QPainter::TextAntialiasing);
  if (workbench_.has_volume()) {
    annotate(painter);
  } else {
    draw_label(painter, rect(), Qt::AlignCenter, tr("Open a volume: Ctrl+O,\nor drop a file here"), theme::kDimText);
  }
}

// Keys act in the view under the mouse, unless something is being typed.
void View::enterEvent(QEnterEvent* event) {
  QWidget* focus = QApplication::focusWidget();
  if (!qobject_cast<QLineEdit*>(focus) && !qobject_cast<QAbstractSpinBox*>(focus)) setFocus(Qt::MouseFocusReason);
  QOpenGLWidget::enterEvent(event);
}

void draw_label(QPainter& painter, const QRectF& box, int alignment, const QString& text, const QColor& colour) {
  painter.setPen(QColor(0, 0, 0, 190));
  for (const QPointF offset : {QPointF(1, 1), QPointF(-1, 1), QPointF(1, -1), QPointF(-1, -1)}) {
    painter.drawText(box.translated(offset), alignment, text);
  }
  painter.setPen(colour);
  painter.drawText(box, alignment, text);
}

}  // namespace simplexseg
