// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QTimer>
#include <optional>

#include "gui/workbench/frame_statistics.h"

namespace simplexseg {

class Workbench;
struct Advance;

/// Runs the simulation for a fixed time per frame, then lets the views repaint once; the next frame starts when that
/// image is on the screen. With a device, the simulation runs while the image is composed and during the rest of the
/// frame (docs/adr/0027-concurrent-steps.md). The loop stops when nothing moves, and restarts with the next action.
class FrameLoop : public QObject {
  Q_OBJECT
 public:
  explicit FrameLoop(Workbench& workbench);
  /// Runs one frame: steps for SimulationParameters::frame_budget_ms, or ends the concurrent steps; then lets the views
  /// repaint once.
  void tick();
  /// Called by each view when it starts to paint.
  void view_about_to_paint() { statistics_.painted(); }
  /// Called by each view when all views have painted and the image is being composed.
  void view_composing();
  /// Called by each view when its image is on the screen.
  void view_shown();
  /// Sets whether steps run concurrently with drawing; none: only if a device computes the steps.
  void set_concurrent(std::optional<bool> concurrent) { concurrent_ = concurrent; }
  bool settled() const { return settled_; }
  /// Returns false while nothing can move: the simulation is paused or settled, or there is no mesh.
  bool active() const { return timer_.isActive(); }
  /// Simulation steps per second and computing time per step, smoothed over some frames; 0 before the first step.
  double steps_per_second() const { return steps_per_second_; }
  double step_ms() const { return step_ms_; }
  FrameStatistics& statistics() { return statistics_; }
  const FrameStatistics& statistics() const { return statistics_; }
  /// Sets the time (FrameStatistics::now_s()) of the mouse event that will move a point next.
  void expect_move(double since_s) { move_since_s_ = since_s; }

 signals:
  void ticked();

 private:
  void resume();
  void on_point_moved();
  void on_advance_finished();
  void begin_concurrent();
  void count(const Advance& done);

  Workbench& workbench_;
  QTimer timer_;
  FrameStatistics statistics_;
  std::optional<double> move_since_s_;
  bool settled_ = false;
  std::optional<bool> concurrent_;
  bool ticked_ = false;             ///< tick() has run since the last concurrent steps began
  bool shown_ = false;              ///< the image of the current concurrent steps is on the screen
  bool finished_ = false;           ///< the current concurrent steps have finished
  bool moved_ = false;              ///< a point has moved since the last image was shown
  bool begins_when_shown_ = false;  ///< concurrent steps wait for the image
  bool resumed_ = false;            ///< resume() was called after the current steps began
  bool counted_ = false;            ///< the current steps are in the statistics
  double steps_per_second_ = 0, step_ms_ = 0;
  double last_tick_s_ = 0;
};

}  // namespace simplexseg
