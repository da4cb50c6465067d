// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <optional>

#include "gui/input/bindings.h"
#include "gui/look/view_state.h"

namespace simplexseg {

class ActionTable;
class FrameLoop;
class ViewGrid;
class Workbench;

/// Handlers of the menu entries for tools, editing, simulation and view. Also enables and checks these entries.
class WorkbenchActions : public QObject {
 public:
  WorkbenchActions(Workbench& workbench, FrameLoop& loop, ViewGrid& views, ActionTable& actions, QObject* parent);

 private:
  void connect_tools();
  void connect_editing();
  void connect_meshes();
  void connect_simulation();
  void connect_view();
  /// Connects a checkable entry to a member of the view state.
  void connect_toggle(Act act, bool ViewState::*member);
  void refresh();
  /// Shows Pause while anything moves, otherwise Run.
  void refresh_run();
  void refresh_solving();
  static QString why_no_mesh();
  void refresh_inside_tool();
  void refresh_toggles();
  void change_opacity(float by);
  int place_of_active() const;  ///< index in the list of meshes; -1: there is none
  void move_mesh(int by);

  Workbench& workbench_;
  FrameLoop& loop_;
  ViewGrid& views_;
  ActionTable& actions_;
  std::optional<bool> shows_pause_;  ///< none: not shown yet
};

}  // namespace simplexseg
