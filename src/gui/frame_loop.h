// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QTimer>

namespace simplexseg {

class Workbench;

/// Gives the simulation a fixed time in each frame, then lets the views repaint once. Stands still when nothing moves,
/// and starts again when an action arrives.
class FrameLoop : public QObject {
  Q_OBJECT
 public:
  explicit FrameLoop(Workbench& workbench);
  /// One frame: simulation.frame_budget ms of steps, one refresh.
  void tick();
  bool at_rest() const { return at_rest_; }
  /// False while nothing can move: paused, at rest, no mesh.
  bool active() const { return timer_.isActive(); }
  /// Smoothed over some frames; 0 when nothing has run yet.
  double steps_per_second() const { return steps_per_second_; }
  double step_ms() const { return step_ms_; }

 signals:
  void ticked();

 private:
  void wake();

  Workbench& workbench_;
  QTimer timer_;
  bool at_rest_ = false;
  double steps_per_second_ = 0, step_ms_ = 0;
  double last_tick_s_ = 0;
};

}  // namespace simplexseg
