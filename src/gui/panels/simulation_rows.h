// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <vector>

class QLabel;

namespace simplexseg {

class ParameterRow;
class Workbench;

/// The parameters of the simulation, made from their table, and below them what the one under the mouse is.
class SimulationRows : public QWidget {
 public:
  SimulationRows(Workbench& workbench, QWidget* parent);
  /// The row of a parameter, in the order of the table.
  ParameterRow* row(int parameter) const;

 private:
  void refresh();

  Workbench& workbench_;
  std::vector<ParameterRow*> rows_;
  std::vector<QLabel*> labels_;  ///< the names of the rows
};

}  // namespace simplexseg
