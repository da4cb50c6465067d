// SPDX-License-Identifier: Apache-2.0
#include "gui/input/key_return.h"

#include <QAbstractSpinBox>
#include <QApplication>
#include <QKeyEvent>
#include <QLineEdit>

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
  QLineEdit* line = focused_line();
  if (!line || watched != QApplication::focusWidget() || line->window() != &window_ || line->isReadOnly()) return false;
  const int key = static_cast<QKeyEvent*>(event)->key();
  if (key == Qt::Key_Escape) {
    while (line->isUndoAvailable()) line->undo();
  } else if (key != Qt::Key_Return && key != Qt::Key_Enter) {
    return false;
  }
  line->setModified(false);
  give_back_.setFocus(Qt::OtherFocusReason);  // a field that loses the focus takes what was typed
  return true;
}

}  // namespace simplexseg
