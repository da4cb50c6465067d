// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QStatusBar>

class QLabel;

namespace simplexseg {

class DrawnScene;
class Workbench;

/// The last line of the window: where the crosshair is and what lies there, how the views are drawn, window and level.
class StatusLine : public QStatusBar {
 public:
  StatusLine(Workbench& workbench, DrawnScene& drawn, QWidget* parent);

 private:
  void refresh_view();
  void refresh_manner();

  Workbench& workbench_;
  DrawnScene& drawn_;
  QLabel* place_;
  QLabel* manner_;
  QLabel* contrast_;
};

}  // namespace simplexseg
