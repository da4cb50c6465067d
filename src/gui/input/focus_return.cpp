// SPDX-License-Identifier: Apache-2.0
#include "gui/input/focus_return.h"

#include <QAbstractSpinBox>
#include <QApplication>
#include <QKeyEvent>
#include <QLineEdit>

namespace simplexseg {
namespace {

/// Returns the text field, or the field of the spin box, that has the focus; null if there is none.
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

FocusReturn::FocusReturn(QWidget& window, QWidget& target) : QObject(&window), window_(window), target_(target) {
  QApplication::instance()->installEventFilter(this);
}

bool FocusReturn::eventFilter(QObject* watched, QEvent* event) {
  const bool may_be_shortcut = event->type() == QEvent::ShortcutOverride;
  if (event->type() != QEvent::KeyPress && !may_be_shortcut) return false;
  QLineEdit* line = focused_line();
  if (!line || watched != QApplication::focusWidget() || line->window() != &window_ || line->isReadOnly()) return false;
  const int key = static_cast<QKeyEvent*>(event)->key();
  if (may_be_shortcut) {
    if (key != Qt::Key_Escape) return false;
    event->accept();  // the key press follows, and not the menu entry with this key
    return true;
  }
  if (key == Qt::Key_Escape) {
    while (line->isUndoAvailable()) line->undo();
  } else if (key != Qt::Key_Return && key != Qt::Key_Enter) {
    return false;
  }
  line->setModified(false);
  target_.setFocus(Qt::OtherFocusReason);  // the field applies its text when it loses the focus
  return true;
}

}  // namespace simplexseg
