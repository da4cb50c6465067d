// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

namespace simplexseg {

/// Recorded times of frames, in seconds.
struct FrameRecord {
  std::vector<double> frame_s;     ///< time between two images
  std::vector<double> latency_s;   ///< from the mouse event to the image with the moved point
  std::vector<double> response_s;  ///< from the mouse event to the image of the first step with the moved point
  long steps = 0;
  double step_seconds = 0;  ///< computing time of all these steps
};

/// Frame rate, steps per frame, and latency of a moved boundary point. The caller reports all events in their order.
/// All times are in seconds, on the clock of now_s().
class FrameStatistics {
 public:
  /// Current time of a monotonic clock, s.
  static double now_s();

  void steps_done(int steps, double seconds);
  /// Records that a mouse event at `since_s` has moved a point.
  void point_moved(double since_s);
  /// Records that the views start to paint the current state.
  void painted();
  /// Records that the painted image is on the screen. Called once per view; returns true for the first view only.
  bool shown(double now_s);
  /// Excludes the time since the last image, during which nothing had to be shown.
  void interrupt() { last_shown_s_.reset(); }

  /// Frame rate (1/s) and steps per frame, smoothed over some frames; 0 before the second image.
  double frames_per_second() const { return interval_s_ > 0 ? 1 / interval_s_ : 0; }
  double steps_per_frame() const { return steps_per_frame_; }

  using Record = FrameRecord;
  void start_recording();
  /// Ends the recording and returns the times since start_recording(); empty if none was started.
  Record stop_recording();

 private:
  struct Move {
    double since_s;
    bool stepped = false, painted = false, painted_after_step = false, shown = false;
  };
  bool image_pending_ = false;
  std::optional<double> last_shown_s_;
  double interval_s_ = 0, steps_per_frame_ = 0;
  int steps_since_shown_ = 0;
  std::vector<Move> moves_;  ///< moves without an image of a later step; only while recording
  std::optional<Record> record_;
};

/// Percentile of the values by nearest rank; `share` in 0..1. Returns 0 without values.
double percentile(std::vector<double> values, double share);

}  // namespace simplexseg
