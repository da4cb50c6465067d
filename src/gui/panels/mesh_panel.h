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

/// The meshes, a card for each, and what makes a new one.
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
  /// The gap between cards that is nearest: 0 before the first.
  int gap_at(const QPoint& on_screen) const;
  void show_gap(int gap);
  void drop(MeshCard& card, int gap);

  Workbench& workbench_;
  FrameLoop& loop_;
  ActionTable& actions_;
  QWidget* list_;
  QVBoxLayout* column_;
  QLabel* empty_;
  QFrame* gap_;  ///< where a card that is dragged would go
  std::vector<MeshCard*> cards_;
  QDoubleSpinBox* radius_;
  QPushButton* add_;
  QTimer states_;  ///< while they change with every frame
};

}  // namespace simplexseg
