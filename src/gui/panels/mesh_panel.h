// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <vector>

#include "session/scene.h"

class QDoubleSpinBox;
class QPushButton;
class QTreeWidget;
class QTreeWidgetItem;

namespace simplexseg {

class ActionTable;
class Workbench;

/// The list of meshes, and what is done to one of them.
class MeshPanel : public QWidget {
  Q_OBJECT
 public:
  MeshPanel(Workbench& workbench, ActionTable& actions, QWidget* parent);

 private:
  void refresh();
  void refresh_counts();
  void edited(QTreeWidgetItem* row, int column);
  void add_at_crosshair();
  void choose_colour();

  Workbench& workbench_;
  QTreeWidget* list_;
  QDoubleSpinBox* radius_;
  QPushButton* add_;
  QPushButton* colour_;
  QPushButton* reset_;
  QPushButton* refine_;
  QPushButton* record_;
  QPushButton* delete_;
  std::uint64_t counted_topology_ = ~std::uint64_t{0};
};

}  // namespace simplexseg
