// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QTimer>
#include <optional>

#include "gui/workbench/frame_statistics.h"

namespace simplexseg {

class Workbench;
struct Advance;

/// Gives the simulation a fixed time in each frame, then lets the views repaint once; the next frame begins when that
/// picture is on the screen. Where a device computes, the simulation has its time while the picture is brought to the
/// screen, and what is left of a frame (docs/adr/0027-beside-the-picture.md). Stands still when nothing moves, and
/// starts again when an action arrives.
class FrameLoop : public QObject {
  Q_OBJECT
 public:
  explicit FrameLoop(Workbench& workbench);
  /// One frame: simulation.frame_budget ms of steps, one refresh.
  void tick();
  /// Each view calls it when it begins to paint.
  void view_about_to_paint() { statistics_.painted(); }
  /// Each view calls it when all have painted and the picture is put together.
  void view_composing();
  /// Each view calls it when what it painted is on the screen.
  void view_shown();
  /// Whether the simulation goes on beside pictures; none: where a device computes.
  void go_on_beside(std::optional<bool> whether) { beside_ = whether; }
  bool at_rest() const { return at_rest_; }
  /// False while nothing can move: paused, at rest, no mesh.
  bool active() const { return timer_.isActive(); }
  /// Smoothed over some frames; 0 when nothing has run yet.
  double steps_per_second() const { return steps_per_second_; }
  double step_ms() const { return step_ms_; }
  FrameStatistics& statistics() { return statistics_; }
  const FrameStatistics& statistics() const { return statistics_; }
  /// The movement of the mouse that will move a point next came at this time (FrameStatistics::now_s), and waited
  /// since.
  void expect_move(double since_s) { move_since_s_ = since_s; }

 signals:
  void ticked();

 private:
  void wake();
  void note_move();
  void note_advanced();
  void begin_beside();
  void count(const Advance& done);

  Workbench& workbench_;
  QTimer timer_;
  FrameStatistics statistics_;
  std::optional<double> move_since_s_;
  bool at_rest_ = false;
  std::optional<bool> beside_;
  bool ticked_ = false;             ///< since the simulation went on beside a picture
  bool shown_ = false;              ///< the picture beside which it goes on
  bool ended_ = false;              ///< what went on beside it
  bool moved_ = false;              ///< a point, since a picture was shown
  bool begins_when_shown_ = false;  ///< what else would go on beside the picture
  bool woken_ = false;              ///< by what came after the steps that are told of next
  bool counted_ = false;            ///< that, in the statistics
  double steps_per_second_ = 0, step_ms_ = 0;
  double last_tick_s_ = 0;
};

}  // namespace simplexseg
