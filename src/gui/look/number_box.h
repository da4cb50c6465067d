// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDoubleSpinBox>
#include <QLocale>

namespace simplexseg {

/// Field for a number. It shows a decimal point under every locale, and takes an entered comma for one: Qt would remove
/// it, or the point under a German locale, as a separator of thousands, and make 15 of 1.5.
class NumberBox : public QDoubleSpinBox {
 public:
  explicit NumberBox(QWidget* parent) : QDoubleSpinBox(parent) { setLocale(QLocale::c()); }

 protected:
  QValidator::State validate(QString& text, int& position) const override {
    text.replace(',', '.');
    return QDoubleSpinBox::validate(text, position);
  }
};

}  // namespace simplexseg
