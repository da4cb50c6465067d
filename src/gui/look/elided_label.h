// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLabel>

namespace simplexseg {

/// Label of one line, whose text is shortened with an ellipsis if it does not fit.
class ElidedLabel : public QLabel {
 public:
  using QLabel::QLabel;
  QSize minimumSizeHint() const override;

 protected:
  void paintEvent(QPaintEvent* event) override;
};

}  // namespace simplexseg
