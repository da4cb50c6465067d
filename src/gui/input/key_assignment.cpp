// SPDX-License-Identifier: Apache-2.0
#include "gui/input/key_assignment.h"

#include <QKeyEvent>
#include <QMetaEnum>

namespace simplexseg {
namespace {

QKeySequence key_in_table(Act act) { return QKeySequence(QString::fromLatin1(binding_of(act).keys)); }

bool is_modifier(Qt::Key key) {
  return key == Qt::Key_Shift || key == Qt::Key_Control || key == Qt::Key_Alt || key == Qt::Key_Meta ||
         key == Qt::Key_AltGr || key == Qt::Key_CapsLock || key == Qt::Key_NumLock;
}

}  // namespace

const char* name_of(Act act) { return QMetaEnum::fromType<Act>().valueToKey(static_cast<int>(act)); }

std::optional<Act> act_named(const std::string& name) {
  bool known = false;
  const int value = QMetaEnum::fromType<Act>().keyToValue(name.c_str(), &known);
  if (!known || !has_key(static_cast<Act>(value))) return std::nullopt;
  return static_cast<Act>(value);
}

bool has_key(Act act) { return *binding_of(act).keys != 0; }

QString title_of(Act act) {
  const Binding& binding = binding_of(act);
  QString title = QString::fromUtf8(*binding.title ? binding.title : binding.help);
  return title.remove('&').remove("...");
}

QKeySequence key_of_event(const QKeyEvent& event) {
  const int key = event.key();
  if (key == 0 || key == Qt::Key_unknown || is_modifier(static_cast<Qt::Key>(key))) return {};
  Qt::KeyboardModifiers modifiers = event.modifiers() & ~Qt::KeypadModifier;
  const QString text = event.text();
  if (!text.isEmpty() && text[0].isPrint() && !text[0].isLetterOrNumber() && !text[0].isSpace())
    modifiers &= ~Qt::ShiftModifier;
  return QKeySequence(QKeyCombination(modifiers, static_cast<Qt::Key>(key)));
}

QString defect_of_key(const QKeySequence& key) {
  if (key.count() != 1 || key[0].key() == Qt::Key_unknown) return QObject::tr("it is not a single key");
  const Qt::Key code = key[0].key();
  const Qt::KeyboardModifiers modifiers = key[0].keyboardModifiers();
  if (is_modifier(code)) return QObject::tr("it is held with the mouse");
  if (code == Qt::Key_Tab || code == Qt::Key_Backtab) return QObject::tr("it moves the keyboard focus");
  if (code == Qt::Key_Return || code == Qt::Key_Enter) return QObject::tr("it accepts what is typed");
  if (modifiers == Qt::AltModifier && code >= Qt::Key_A && code <= Qt::Key_Z)
    return QObject::tr("Alt with a letter opens menus");
  if (modifiers == Qt::AltModifier && code == Qt::Key_F4) return QObject::tr("the desktop closes windows with it");
  return {};
}

QKeySequence KeyAssignment::key_of(Act act) const {
  const auto found = changed_.find(act);
  return found == changed_.end() ? key_in_table(act) : found->second;
}

std::optional<Act> KeyAssignment::act_with(const QKeySequence& key, std::optional<Act> except) const {
  if (key.isEmpty()) return std::nullopt;
  for (const Binding& binding : bindings())
    if (*binding.keys && binding.act != except && key_of(binding.act) == key) return binding.act;
  return std::nullopt;
}

void KeyAssignment::set(Act act, const QKeySequence& key) {
  if (!key.isEmpty() && !defect_of_key(key).isEmpty()) return;
  if (const std::optional<Act> other = act_with(key, act)) changed_[*other] = {};
  if (key == key_in_table(act))
    changed_.erase(act);
  else
    changed_[act] = key;
}

void KeyAssignment::reset(Act act) { set(act, key_in_table(act)); }

KeyAssignment KeyAssignment::with_changed(const std::map<Act, QKeySequence>& changed) {
  KeyAssignment keys;
  for (const auto& [act, key] : changed)
    if (key != key_in_table(act)) keys.changed_[act] = key;
  return keys;
}

}  // namespace simplexseg
