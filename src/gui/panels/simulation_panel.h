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

/// Controls of the simulation (run, pause, step, reset), its speed and state, and its parameters.
class SimulationPanel : public QWidget {
  Q_OBJECT
 public:
  SimulationPanel(Workbench& workbench, FrameLoop& loop, ActionTable& actions, QWidget* parent);
  /// Shows `how`, the transfer mode and renderer of the views, beside the backend.
  void show_drawing(const QString& how);
  /// Row of a parameter; `parameter` is its index in the table.
  ParameterRow* row(int parameter) const;
  const QLabel* motion() const { return motion_; }
  const QLabel* surface() const { return surface_; }

 private:
  void refresh_status();
  /// Faults (faults_of()) of each mesh with a faulty surface, with the name of the mesh if there are several meshes.
  QStringList faulty_surfaces() const;
  void refresh_surface(const QStringList& faulty);

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
