// SPDX-License-Identifier: Apache-2.0
#include "gui/input/key_return.h"

#include <QApplication>
#include <QDoubleSpinBox>
#include <QKeyEvent>
#include <QLineEdit>
#include <QSignalBlocker>

namespace simplexseg {
namespace {

/// The line of text that has the focus, alone or as part of a number.
QLineEdit* focused_line() {
  QWidget* focus = QApplication::focusWidget();
  if (qobject_cast<QAbstractSpinBox*>(focus)) return focus->findChild<QLineEdit*>();
  return qobject_cast<QLineEdit*>(focus);
}

}  // namespace

bool is_typing() {
  const QLineEdit* line = focused_line();
  return line && line->isModified();
}

KeyReturn::KeyReturn(QWidget& window, QWidget& give_back) : QObject(&window), window_(window), give_back_(give_back) {
  QApplication::instance()->installEventFilter(this);
}

bool KeyReturn::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() != QEvent::KeyPress) return false;
  auto* number = qobject_cast<QDoubleSpinBox*>(watched);
  if (!number || number->window() != &window_) return false;
  const int key = static_cast<QKeyEvent*>(event)->key();
  if (key == Qt::Key_Return || key == Qt::Key_Enter) {
    number->interpretText();
  } else if (key == Qt::Key_Escape) {
    const QSignalBlocker blocker(number);
    number->setValue(number->value());  // in place of what was typed
  } else {
    return false;
  }
  give_back_.setFocus(Qt::OtherFocusReason);
  return true;
}

}  // namespace simplexseg
