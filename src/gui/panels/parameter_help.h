// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLabel>

#include "forces/parameters.h"

namespace simplexseg {

class ParameterRow;

/// What a parameter is, in a sentence, with its default and range: "The weight... Default 0.5 mm, from 0 to 10 mm."
QString help_of(const ParameterInfo& info);

/// The lines below a panel's parameters that say what the one under the mouse, or with the keys, is.
class ParameterHelp : public QLabel {
 public:
  explicit ParameterHelp(QWidget* parent);
  /// `title`: of the parameter, as the panel names it.
  void watch(ParameterRow& row, const QString& title);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
};

}  // namespace simplexseg
