// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLabel>
#include <QTimer>

namespace simplexseg {

class FrameLoop;
class Workbench;
enum class RunState;

/// Label in the toolbar with the state of the simulation.
class StateChip : public QLabel {
 public:
  StateChip(Workbench& workbench, FrameLoop& loop, QWidget* parent);
  RunState state() const { return state_; }

 private:
  void refresh();

  Workbench& workbench_;
  FrameLoop& loop_;
  QTimer refresh_timer_;
  RunState state_;
};

}  // namespace simplexseg
