// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>

#include "gui/input/bindings.h"
#include "gui/look/view_state.h"

namespace simplexseg {

class ActionTable;
class ViewGrid;
class Workbench;

/// The menu entries that act on the workbench: tools, undo, simulation, and what is looked at. What they do, when they
/// can be chosen, and which of them are ticked.
class WorkbenchActions : public QObject {
 public:
  WorkbenchActions(Workbench& workbench, ViewGrid& views, ActionTable& actions, QObject* parent);

 private:
  void connect_tools();
  void connect_editing();
  void connect_meshes();
  void connect_simulation();
  void connect_looking();
  /// The entry is ticked while the member is true.
  void connect_tick(Act act, bool ViewState::*member);
  void refresh();
  void refresh_ticks();
  void change_opacity(float by);
  int place_of_active() const;  ///< in the list of meshes; -1: there is none
  void move_mesh(int by);

  Workbench& workbench_;
  ViewGrid& views_;
  ActionTable& actions_;
};

}  // namespace simplexseg
