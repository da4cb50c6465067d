// SPDX-License-Identifier: Apache-2.0
#include "gui/input/key_map.h"

namespace simplexseg {

KeyMap& KeyMap::shared() {
  static KeyMap map;
  return map;
}

void KeyMap::assign(const KeyAssignment& keys) {
  if (keys == keys_) return;
  keys_ = keys;
  emit changed();
}

QString key_text(Act act) { return KeyMap::shared().keys().key_of(act).toString(QKeySequence::NativeText); }

QString key_hint(Act act) {
  const QString key = key_text(act);
  return key.isEmpty() ? KeyMap::tr("menu entry %1").arg(title_of(act)) : KeyMap::tr("key %1").arg(key);
}

QString why_locked() {
  return KeyMap::tr("The segmentation is locked: unlock it first (%1)").arg(key_hint(Act::LockMesh));
}

}  // namespace simplexseg
