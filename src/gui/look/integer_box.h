// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLocale>
#include <QSpinBox>

namespace simplexseg {

/// Field for a whole number. Refuses points and commas under every locale: Qt would remove them as separators of
/// thousands, and make 15 of 1,5.
class IntegerBox : public QSpinBox {
 public:
  explicit IntegerBox(QWidget* parent) : QSpinBox(parent) { setLocale(QLocale::c()); }
  QValidator::State validate(QString& text, int& position) const override {
    if (text.contains(',') || text.contains('.')) return QValidator::Invalid;
    return QSpinBox::validate(text, position);
  }
};

}  // namespace simplexseg
