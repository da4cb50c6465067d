// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QOpenGLWidget>

#include "gui/painters.h"

class QPainter;

namespace simplexseg {

class Workbench;

/// What the four views have in common: an OpenGL surface that repaints when the workbench has changed.
class View : public QOpenGLWidget {
  Q_OBJECT
 public:
  View(Workbench& workbench, QWidget* parent);
  ~View() override;

  /// The whole volume in view.
  virtual void fit() = 0;
  virtual void centre_on_crosshair() = 0;

 signals:
  void maximise_wanted();

 protected:
  virtual void create_painters() = 0;
  virtual void destroy_painters() = 0;
  virtual void paint() = 0;
  /// Text over the picture.
  virtual void annotate(QPainter& painter) = 0;

  void initializeGL() override;
  void paintGL() override;
  void enterEvent(QEnterEvent* event) override;
  /// Every derived view calls it in its destructor: the objects need the context.
  void release();

  Eigen::Vector2f viewport_px() const;
  Workbench& workbench_;

 private:
  bool ready_ = false;
};

/// Text with a dark halo, readable on any picture. `alignment` within `box`.
void draw_label(QPainter& painter, const QRectF& box, int alignment, const QString& text, const QColor& colour);

}  // namespace simplexseg
