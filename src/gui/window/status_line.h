// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QStatusBar>
#include <QTimer>

class QLabel;

namespace simplexseg {

class DrawnScene;
class Workbench;

/// The last line of the window: where the crosshair is and what lies there, which mesh's object is being learned, how
/// the views are drawn, window and level.
class StatusLine : public QStatusBar {
 public:
  StatusLine(Workbench& workbench, DrawnScene& drawn, QWidget* parent);
  const QLabel* learning() const { return learning_; }

 private:
  void refresh_view();
  void refresh_manner();
  void refresh_learning();

  Workbench& workbench_;
  DrawnScene& drawn_;
  QLabel* place_;
  QLabel* learning_;
  QTimer learned_;  ///< until the text goes: a mesh that learns with every movement of a point must not make it flicker
  QLabel* manner_;
  QLabel* contrast_;
};

}  // namespace simplexseg
