// SPDX-License-Identifier: Apache-2.0
// Keys of the acts, which the user can change.
#pragma once
#include <QKeySequence>
#include <map>
#include <optional>
#include <string>

#include "gui/input/bindings.h"

namespace simplexseg {

/// Keys of all acts with a key in the table of bindings, as differences from that table. No two acts have the same key.
class KeyAssignment {
 public:
  /// Present key; empty: none. Here and below, the act has a key in the table.
  QKeySequence key_of(Act act) const;
  bool is_changed(Act act) const { return changed_.contains(act); }
  bool is_default() const { return changed_.empty(); }
  /// Gives an act a key; an act that had it has none afterwards. An empty key: none. Changes nothing for a
  /// key that defect_of_key() refuses.
  void set(Act act, const QKeySequence& key);
  /// Gives an act its key of the table; an act that had it has none afterwards.
  void reset(Act act);
  void reset_all() { changed_.clear(); }
  /// Act with a key, other than `except`.
  std::optional<Act> act_with(const QKeySequence& key, std::optional<Act> except = {}) const;

  /// Keys of the acts that differ from the table.
  const std::map<Act, QKeySequence>& changed() const { return changed_; }
  /// Assignment with these differences, whose keys are neither refused nor twice in it.
  static KeyAssignment with_changed(const std::map<Act, QKeySequence>& changed);

  bool operator==(const KeyAssignment&) const = default;

 private:
  std::map<Act, QKeySequence> changed_;
};

/// Whether an act has a key in the table of bindings.
bool has_key(Act act);
/// Name of an act in files, for example "ToolBrush".
const char* name_of(Act act);
/// Act with a key in the table that has this name; none if there is none.
std::optional<Act> act_named(const std::string& name);
/// Title of an act without mnemonic: that of its menu entry, else its line in the help.
QString title_of(Act act);
/// Key of a key event as in menus: without Shift for a sign that the keyboard has only with Shift. Empty for a
/// modifier.
QKeySequence key_of_event(const QKeyEvent& event);
/// Reason why a key cannot be used; empty if it can: a single key with modifiers that opens no menu, moves no keyboard
/// focus and ends no input.
QString defect_of_key(const QKeySequence& key);

}  // namespace simplexseg
