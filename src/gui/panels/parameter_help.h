// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLabel>

#include "forces/parameters.h"

namespace simplexseg {

class ParameterRow;

/// Description of a parameter with its default and range, such as "... Default 0.5 mm, from 0 to 10 mm."
QString help_of(const ParameterInfo& info);

/// Help text below the parameters of a panel: describes the parameter under the mouse or with the keyboard focus.
class ParameterHelp : public QLabel {
 public:
  explicit ParameterHelp(QWidget* parent);
  /// Shows the help of `row` while it is under the mouse or has the focus. `title`: name of the parameter in the panel.
  void watch(ParameterRow& row, const QString& title);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
};

}  // namespace simplexseg
