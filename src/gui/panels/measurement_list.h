// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QTreeWidget>

#include "session/scene.h"

namespace simplexseg {

class Workbench;

/// List of the measurements with their values; hidden without one. Selecting one moves the crosshair to it; its name
/// can be edited.
class MeasurementList : public QTreeWidget {
  Q_OBJECT
 public:
  MeasurementList(Workbench& workbench, QWidget* parent);

 private:
  void refresh();
  void follow_selection();
  void rename(QTreeWidgetItem* row);

  Workbench& workbench_;
  ItemId shown_selection_ = 0;
};

}  // namespace simplexseg
