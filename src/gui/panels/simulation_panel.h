// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

class QLabel;
class QToolButton;

namespace simplexseg {

class ActionTable;
class FrameLoop;
class ParameterRow;
class SimulationRows;
class Workbench;

/// Run, pause, step, reset; the parameters of the simulation; how fast it goes.
class SimulationPanel : public QWidget {
  Q_OBJECT
 public:
  SimulationPanel(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent);
  /// How the views are drawn, and by what: shown beside the backend.
  void show_drawing(const QString& how);
  /// The row of a parameter, in the order of its table.
  ParameterRow* row(int parameter) const;
  const QLabel* motion() const { return motion_; }
  const QLabel* surface() const { return surface_; }

 private:
  void refresh_status();
  /// "brain: folded at 12 vertices" for each mesh that is folded or inside out; the name only among several.
  QStringList unsound_meshes() const;
  void refresh_surface(const QStringList& unsound);

  Workbench& workbench_;
  FrameLoop& loop_;
  SimulationRows* rows_;
  QLabel* speed_;
  QLabel* frames_;
  QLabel* vertices_;
  QLabel* motion_;
  QLabel* surface_;
  QLabel* backend_;
  QString drawing_;
};

}  // namespace simplexseg
