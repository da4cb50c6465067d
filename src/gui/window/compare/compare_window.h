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

/// Compares two settings of the active mesh side by side, each with its views and parameters, and the results between
/// them. Either setting can be applied in the main window.
class CompareWindow : public QDialog {
  Q_OBJECT
 public:
  /// `workbench` and its active mesh must outlive the window. Throws the errors of Comparison.
  CompareWindow(Workbench& workbench, const std::function<std::unique_ptr<Engine>()>& make_engine, QWidget* parent);
  ~CompareWindow() override;

  Comparison& comparison() { return *comparison_; }
  ViewGrid& views(int side) const { return *sides_[side].views; }
  ForcePanel& forces(int side) const { return *sides_[side].forces; }
  SimulationRows& simulation(int side) const { return *sides_[side].simulation; }
  /// Text of the table in the column of a side and the row with this title; empty if there is no such row.
  QString table_text(const QString& title, int side) const;
  /// Applies the settings of a side to the mesh in the main window, as one action, and closes this window.
  void apply_settings(int side);
  /// Writes the plot as .png or .svg, or its data as .csv. Throws Error when the file cannot be written.
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
  QTimer refresh_timer_;
};

}  // namespace simplexseg
