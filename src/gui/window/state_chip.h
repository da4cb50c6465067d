// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLabel>
#include <QTimer>

namespace simplexseg {

class FrameLoop;
class Workbench;
enum class RunState;

/// The state of the simulation in two words, in the toolbar.
class StateChip : public QLabel {
 public:
  StateChip(Workbench& workbench, FrameLoop& loop, QWidget* parent);
  RunState state() const { return state_; }

 private:
  void refresh();

  Workbench& workbench_;
  FrameLoop& loop_;
  QTimer calm_;
  RunState state_;
};

}  // namespace simplexseg
