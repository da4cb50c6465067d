// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QFrame>
#include <optional>

#include "session/command.h"

class QLabel;
class QSlider;
class QSpinBox;
class QToolButton;

namespace simplexseg {

class ActionTable;
class ModeSliders;
class NameLine;
class Workbench;

/// Entry of a mesh in the list: colour, name, label, visibility, lock, opacity, volume and state, and buttons that
/// cancel or request the update of its field. A press anywhere on the card makes the mesh active.
class MeshCard : public QFrame {
  Q_OBJECT
 public:
  MeshCard(Workbench& workbench, ActionTable& actions, QWidget* parent);
  void show_mesh(const MeshItem& item, bool active);
  /// Shows the state of the mesh. `advice`: explanation and remedy for the tooltip; may be empty.
  void show_state(const QString& state, bool is_warning, const QString& advice = {});
  /// Shows the button Cancel while the field of the mesh is solved, and the button Solve while marks are pending.
  void show_update(bool solving, bool pending);
  /// Shows the name of the model of the mesh and its trust, the share of the model in the field.
  void show_prior(const MeshItem& item);
  /// Shows the volume; none: it is unknown, because the mesh moves.
  void show_volume(std::optional<double> mm3);
  ItemId mesh() const { return mesh_; }

 signals:
  /// The user drags or drops the card, to move it within the list. `at`: screen coordinates.
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
  /// Applies a change to this mesh; shows the previous values again if the change is refused.
  void edit(const EditMesh& change);
  void choose_colour();

  Workbench& workbench_;
  ItemId mesh_ = 0;
  QPointF pressed_at_;
  bool dragged_ = false;
  QToolButton* colour_;
  NameLine* name_;
  QToolButton* cancel_;
  QToolButton* solve_;
  QToolButton* shown_;
  QToolButton* locked_;
  QSpinBox* label_;
  QSlider* opacity_;
  QLabel* volume_;
  QLabel* state_;
  QLabel* prior_;       ///< model or network; hidden without
  QLabel* images_;      ///< hidden unless images are chosen
  ModeSliders* modes_;  ///< hidden unless the mesh is active and has a model
};

}  // namespace simplexseg
