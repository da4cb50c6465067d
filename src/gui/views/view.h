// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QOpenGLWidget>

#include "gui/drawing/label_painter.h"

namespace simplexseg {

class DrawnScene;
class Workbench;

/// What the four views have in common: an OpenGL surface that repaints when the workbench has changed.
class View : public QOpenGLWidget {
  Q_OBJECT
 public:
  View(Workbench& workbench, DrawnScene& drawn, QWidget* parent);
  ~View() override;

  /// Brings the whole volume into view.
  virtual void fit() = 0;
  virtual void centre_on_crosshair() = 0;

 signals:
  void maximise_wanted();
  void about_to_paint();

 protected:
  virtual void create_painters() = 0;
  virtual void destroy_painters() = 0;
  /// Brings the shared buffers that it will draw from up to date, before anything is drawn: what is written in between
  /// would cut the frame in two. There is a volume.
  virtual void prepare() = 0;
  virtual void paint() = 0;
  /// Adds the text that stands over the picture. There is a volume.
  virtual void annotate(std::vector<Label>& labels) const = 0;

  void initializeGL() override;
  void paintGL() override;
  void enterEvent(QEnterEvent* event) override;
  /// Every derived view calls it in its destructor: its painters need the context to go.
  void destroy_gl_objects();

  /// The names of patient and series, at the upper left of the box, unless they are hidden.
  void add_names(std::vector<Label>& labels, const QRectF& box) const;
  Eigen::Vector2f viewport_px() const;
  Workbench& workbench_;
  DrawnScene& drawn_;

 private:
  LabelPainter label_painter_;
  bool ready_ = false;
};

}  // namespace simplexseg
