// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>

class QWidget;

namespace simplexseg {

/// Whether a number or a text is being typed: the keys belong to it, wherever the mouse is.
bool is_typing();

/// Gives the keys back when somebody has typed into a field of `window`: Return takes what was typed, Esc what was
/// there before, and `give_back` then moves the focus.
class KeyReturn : public QObject {
 public:
  KeyReturn(QWidget& window, QWidget& give_back);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  QWidget& window_;
  QWidget& give_back_;
};

}  // namespace simplexseg
