// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

#include "session/layer.h"

class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QSlider;
class QTreeWidget;
class QTreeWidgetItem;

namespace simplexseg {

class ActionTable;
class Workbench;

/// List of the layers (check mark: shown; a double click renames), and the display of the active one.
class LayerPanel : public QWidget {
  Q_OBJECT
 public:
  LayerPanel(Workbench& workbench, ActionTable& actions, QWidget* parent);

 private:
  const LayerItem* active() const;
  void refresh();
  void edit_row(QTreeWidgetItem* row);
  void set_opacity(int percent);
  void set_contrast();
  QString transform_text(const LayerItem& layer) const;

  Workbench& workbench_;
  QTreeWidget* list_;
  QComboBox* colours_;
  QSlider* opacity_;
  QLabel* percent_;
  QDoubleSpinBox *window_, *level_;
  QLabel *unit_, *transform_, *filters_, *volume_;
  bool opacity_dragged_ = false;  ///< the current drag of the slider has already changed the layer
};

}  // namespace simplexseg
