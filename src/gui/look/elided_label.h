// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLabel>

namespace simplexseg {

/// One line of text that ends in dots where there is no room for all of it.
class ElidedLabel : public QLabel {
 public:
  using QLabel::QLabel;
  QSize minimumSizeHint() const override;

 protected:
  void paintEvent(QPaintEvent* event) override;
};

}  // namespace simplexseg
