// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>

#include "gui/input/key_assignment.h"

namespace simplexseg {

/// Keys of the program, which all windows use. Menu entries, views, help and texts follow changed().
class KeyMap : public QObject {
  Q_OBJECT
 public:
  static KeyMap& shared();
  const KeyAssignment& keys() const { return keys_; }
  void assign(const KeyAssignment& keys);

 signals:
  void changed();

 private:
  KeyAssignment keys_;
};

/// Present key of an act as the desktop writes it; "" if it has none.
QString key_text(Act act);
/// Like key_text() in a sentence: "key 4", or "menu entry New segmentation" if it has no key.
QString key_hint(Act act);
/// Reason why controls of a locked segmentation are disabled, with the key that unlocks it.
QString why_locked();

}  // namespace simplexseg
