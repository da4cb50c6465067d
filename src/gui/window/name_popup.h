// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QFrame>

#include "session/scene.h"

namespace simplexseg {

class NameLine;
class Workbench;

/// Small field beside a new seed or box, in which the user can type the name of the segmentation at once. It appears if
/// the scene has a label preset, or on request. Enter accepts; Escape, or a click elsewhere with nothing typed, keeps
/// the name.
class NamePopup : public QFrame {
  Q_OBJECT
 public:
  /// `area`: widget in which it appears.
  NamePopup(Workbench& workbench, QWidget& area);
  /// Shows the field for the active mesh, near the mouse if it is in the area.
  void ask();
  NameLine& line() const { return *line_; }

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void close_with(const QString& typed);

  Workbench& workbench_;
  QWidget& area_;
  NameLine* line_;
  ItemId mesh_ = 0;  ///< mesh that gets the name; 0: none
};

}  // namespace simplexseg
