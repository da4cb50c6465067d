// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <functional>
#include <map>

#include "gui/input/bindings.h"

class QAction;
class QWidget;

namespace simplexseg {

/// Menu entries: one QAction for every act of scope Everywhere, with the present keys (KeyMap).
class ActionTable : public QObject {
 public:
  /// `window`: window in which the shortcuts are active.
  explicit ActionTable(QWidget& window);
  /// Menu entry of an act. Here and below, the act must have the scope Everywhere.
  QAction* operator[](Act act) const { return actions_.at(act); }
  void on(Act act, std::function<void()> handler);
  /// Makes the entry checkable, and calls the handler with the new state.
  void on_toggle(Act act, std::function<void(bool)> handler);

 private:
  void show_keys();

  std::map<Act, QAction*> actions_;
};

}  // namespace simplexseg
