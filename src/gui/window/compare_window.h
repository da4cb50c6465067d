// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <QTimer>
#include <array>
#include <functional>
#include <memory>

#include "gui/workbench/comparison.h"

class QComboBox;
class QLabel;
class QPushButton;
class QSplitter;
class QTableWidget;
class QToolButton;
class QVBoxLayout;

namespace simplexseg {

class DrawnScene;
class Engine;
class ForcePanel;
class PlotPicture;
class SimulationRows;
class ViewGrid;
class Workbench;

/// Two settings of the active mesh beside each other, each with its views and its parameters; between them what came
/// of them. One of the two can be taken over into the window that it was opened from.
class CompareWindow : public QDialog {
  Q_OBJECT
 public:
  /// Throws Error as Comparison does. `workbench` must live as long, with the mesh that is active now.
  CompareWindow(Workbench& workbench, const std::function<std::unique_ptr<Engine>()>& make_engine, QWidget* parent);
  ~CompareWindow() override;

  Comparison& comparison() { return *comparison_; }
  ViewGrid& views(int side) const { return *sides_[side].views; }
  ForcePanel& forces(int side) const { return *sides_[side].forces; }
  SimulationRows& simulation(int side) const { return *sides_[side].simulation; }
  /// What the table says of a side in the row of this title; empty where there is no such row.
  QString figure(const QString& title, int side) const;
  /// Gives the settings of a side to the mesh in the window, as one action, and closes.
  void take(int side);
  /// The plot as .png or .svg, or its numbers as .csv. Throws Error.
  void save_to(const QString& path) const;

 private:
  struct Side {
    std::unique_ptr<DrawnScene> drawn;
    ViewGrid* views;
    ForcePanel* forces;
    SimulationRows* simulation;
    QLabel* state;
  };
  QWidget* build_side(int side);
  QWidget* build_middle();
  void build_bar(QVBoxLayout& column);
  void link_views();
  void show_view(int which);
  void refresh();
  void refresh_table();
  void draw();
  QString state_of(int side) const;
  bool plots_errors() const;
  Plot plot() const;
  void choose_and_save();

  Workbench& workbench_;
  std::unique_ptr<Comparison> comparison_;
  std::array<Side, Comparison::kSides> sides_;
  QSplitter* columns_;
  QToolButton* run_;
  QComboBox* shown_;
  QLabel* message_;
  QTableWidget* table_;
  QComboBox* quantity_;
  PlotPicture* picture_;
  QPushButton* save_;
  QTimer calm_;
};

}  // namespace simplexseg
