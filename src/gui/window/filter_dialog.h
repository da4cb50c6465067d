// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <vector>

#include "image/preprocessing.h"

class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QLabel;

namespace simplexseg {

/// Choice of a filter with its parameters, and list of the filters that an image has already.
class FilterDialog : public QDialog {
  Q_OBJECT
 public:
  /// `keeps_grid`: filters that change the grid are disabled.
  FilterDialog(const QString& title, std::vector<FilterStep> present, bool keeps_grid, QWidget* parent);
  /// Filters of the image after the dialog: those before with the chosen one, or without the last.
  const std::vector<FilterStep>& filters() const { return filters_; }

 private:
  void show_parameters();
  FilterStep chosen() const;

  std::vector<FilterStep> filters_;
  QComboBox* kind_;
  QLabel* help_;
  QFormLayout* form_;
  std::vector<QDoubleSpinBox*> values_;  ///< parameters of the chosen filter
};

}  // namespace simplexseg
