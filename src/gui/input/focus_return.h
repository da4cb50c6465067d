// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>

class QWidget;

namespace simplexseg {

/// Returns true while the user is typing a number or a text: all keys then go to that field, wherever the mouse is.
bool is_typing();

/// Ends typing in the fields of `window`: Return accepts the text, Esc restores the former one, and both move the focus
/// to `target`. In a field, Esc has this effect and not that of a menu entry.
class FocusReturn : public QObject {
 public:
  FocusReturn(QWidget& window, QWidget& target);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  QWidget& window_;
  QWidget& target_;
};

}  // namespace simplexseg
