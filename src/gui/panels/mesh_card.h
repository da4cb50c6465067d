// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QFrame>

#include "session/command.h"

class QLabel;
class QLineEdit;
class QSlider;
class QSpinBox;
class QToolButton;

namespace simplexseg {

class ActionTable;
class Workbench;

/// One mesh in the list: colour, name, label, what is shown of it, whether it is locked, how large it is and how it
/// fares. A press anywhere on it makes the mesh active.
class MeshCard : public QFrame {
  Q_OBJECT
 public:
  MeshCard(Workbench& workbench, ActionTable& actions, QWidget* parent);
  void show_mesh(const MeshItem& item, bool active);
  /// `advice`: what it means and what can be done; may be empty.
  void show_state(const QString& state, bool is_warning, const QString& advice = {});
  /// `millilitres` below 0: not known while it moves.
  void show_volume(double millilitres);
  ItemId mesh() const { return mesh_; }

 signals:
  /// The user drags the card, and lets it go: to be given another place in the list. Of the screen.
  void dragged(const QPoint& at);
  void dropped(const QPoint& at);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;

 private:
  void build_upper_row(ActionTable& actions);
  void build_lower_row();
  /// Carries out a change of this mesh; shows what is where it was refused.
  void edit(const EditMesh& change);
  void choose_colour();

  Workbench& workbench_;
  ItemId mesh_ = 0;
  QPointF pressed_at_;
  bool dragged_ = false;
  QToolButton* colour_;
  QLineEdit* name_;
  QToolButton* shown_;
  QToolButton* locked_;
  QSpinBox* label_;
  QSlider* opacity_;
  QLabel* volume_;
  QLabel* state_;
};

}  // namespace simplexseg
