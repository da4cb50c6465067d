// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

#include "session/scene.h"

class QPushButton;
class QTreeWidget;

namespace simplexseg {

class Workbench;

/// List of the points; selecting one moves the crosshair to it.
class PointPanel : public QWidget {
  Q_OBJECT
 public:
  PointPanel(Workbench& workbench, QWidget* parent);

 private:
  void refresh();
  void follow_selection();

  Workbench& workbench_;
  QTreeWidget* list_;
  QPushButton* delete_;
  ItemId shown_selection_ = 0;
};

}  // namespace simplexseg
