// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <vector>

class QLabel;

namespace simplexseg {

class ParameterRow;
class Workbench;

/// Widget with one row for each simulation parameter, and a help text below the rows.
class SimulationRows : public QWidget {
 public:
  SimulationRows(Workbench& workbench, QWidget* parent);
  /// Row of a parameter; `parameter` is its index in the table.
  ParameterRow* row(int parameter) const;

 private:
  void refresh();

  Workbench& workbench_;
  std::vector<ParameterRow*> rows_;
  std::vector<QLabel*> labels_;  ///< names of the parameters
};

}  // namespace simplexseg
