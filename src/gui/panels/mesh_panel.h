// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QTimer>
#include <QWidget>
#include <vector>

#include "session/scene.h"

class QDoubleSpinBox;
class QFrame;
class QLabel;
class QPushButton;
class QVBoxLayout;

namespace simplexseg {

class ActionTable;
class FrameLoop;
class MeshCard;
class Workbench;

/// List of the meshes, one card each, and the controls that add a mesh.
class MeshPanel : public QWidget {
  Q_OBJECT
 public:
  MeshPanel(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent);
  const std::vector<MeshCard*>& cards() const { return cards_; }

 private:
  void build_list();
  void build_adding();
  void refresh();
  void refresh_states();
  void add_at_crosshair();
  /// Index of the nearest gap between cards; 0 is above the first card.
  int gap_at(const QPoint& on_screen) const;
  void show_gap(int gap);
  void drop(MeshCard& card, int gap);

  Workbench& workbench_;
  FrameLoop& loop_;
  ActionTable& actions_;
  QWidget* list_;
  QVBoxLayout* column_;
  QLabel* empty_;
  QFrame* gap_;  ///< marks where the dragged card would be dropped
  std::vector<MeshCard*> cards_;
  QDoubleSpinBox* radius_;
  QPushButton* add_;
  QTimer states_;  ///< limits how often states and volumes are refreshed
};

}  // namespace simplexseg
