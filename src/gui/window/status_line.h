// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QStatusBar>
#include <QStringList>
#include <QTimer>

class QLabel;

namespace simplexseg {

class DrawnScene;
class Workbench;

/// Status line of the window: position and intensity at the crosshair; name of the mesh whose field is being solved,
/// with the completed percentage; renderer; window and level.
class StatusLine : public QStatusBar {
 public:
  StatusLine(Workbench& workbench, DrawnScene& drawn, QWidget* parent);
  const QLabel* solving() const { return solving_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  void refresh_view();
  /// Shows the longest text of the position that fits.
  void show_position();
  void refresh_renderer();
  void refresh_solving();

  Workbench& workbench_;
  DrawnScene& drawn_;
  QLabel* position_;
  QStringList positions_;  ///< texts of the position, the longest first
  QLabel* solving_;
  QTimer clear_timer_;  ///< delay until solving_ is cleared, so that it does not flicker during a drag
  QLabel* renderer_;
  QLabel* contrast_;
};

}  // namespace simplexseg
