// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <functional>
#include <map>

#include "gui/input/bindings.h"

class QAction;
class QWidget;

namespace simplexseg {

/// The menu entries: one QAction for every act that the table of bindings has for everywhere.
class ActionTable : public QObject {
 public:
  /// The actions' shortcuts are valid in `window`.
  explicit ActionTable(QWidget& window);
  /// The act must be one for everywhere, also for the following.
  QAction* operator[](Act act) const { return actions_.at(act); }
  void on(Act act, std::function<void()> handler);
  /// Calls the handler with whether the entry is ticked now.
  void on_toggle(Act act, std::function<void(bool)> handler);

 private:
  std::map<Act, QAction*> actions_;
};

}  // namespace simplexseg
