// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QOpenGLWidget>

#include "gui/drawing/label_painter.h"

namespace simplexseg {

class DrawnScene;
class Workbench;

/// Base class of the four views: an OpenGL widget that repaints when the workbench has changed.
class View : public QOpenGLWidget {
  Q_OBJECT
 public:
  View(Workbench& workbench, DrawnScene& drawn, QWidget* parent);
  ~View() override;

  /// Fits the whole volume into the view.
  virtual void fit() = 0;
  virtual void centre_on_crosshair() = 0;

 public slots:
  /// Repaints the view, because only poses or the progress of a solution have changed.
  virtual void show_progress() { update(); }

 signals:
  void maximise_requested();
  void about_to_paint();

 protected:
  virtual void create_painters() = 0;
  virtual void destroy_painters() = 0;
  /// Updates the shared buffers before anything is drawn, so that no write interrupts the drawing. Needs a volume.
  virtual void prepare() = 0;
  virtual void paint() = 0;
  /// Adds the labels that are drawn over the image. Needs a volume.
  virtual void annotate(std::vector<Label>& labels) const = 0;

  void initializeGL() override;
  void paintGL() override;
  void enterEvent(QEnterEvent* event) override;
  /// Releases the OpenGL objects. The destructor of every derived class calls it, because it needs destroy_painters().
  void destroy_gl_objects();

  /// Adds the names of patient and series at the upper left of `box`, unless hidden.
  void add_names(std::vector<Label>& labels, const QRectF& box) const;
  Eigen::Vector2f viewport_px() const;
  Workbench& workbench_;
  DrawnScene& drawn_;

 private:
  LabelPainter label_painter_;
  bool ready_ = false;
};

}  // namespace simplexseg
