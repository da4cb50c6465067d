// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

namespace simplexseg {

/// Recorded times of frames, in seconds.
struct FrameRecord {
  std::vector<double> frame_s;     ///< time between two images
  std::vector<double> latency_s;   ///< from the mouse event to the image with the moved point
  std::vector<double> response_s;  ///< from the mouse event to the image of the first step that includes it
  long steps = 0;
  double step_seconds = 0;  ///< computing time of these steps
};

/// Frame rate, steps per frame, and latency of a moved boundary point. The caller reports all events in their order.
/// Times in seconds, on the clock of now_s().
class FrameStatistics {
 public:
  /// Current time of a monotonic clock, s.
  static double now_s();

  void steps_done(int steps, double seconds);
  /// A mouse event at `since_s` has moved a point.
  void point_moved(double since_s);
  /// The views start to paint the current state.
  void painted();
  /// The painted image is on the screen. Called once per view; true for the first.
  bool shown(double now_s);
  /// Excludes the time since the last image, during which nothing had to be shown.
  void interrupt() { last_shown_s_.reset(); }

  /// Frame rate and steps per frame, smoothed over some frames; 0 before the first frame.
  double frames_per_second() const { return interval_s_ > 0 ? 1 / interval_s_ : 0; }
  double steps_per_frame() const { return steps_per_frame_; }

  using Record = FrameRecord;
  void start_recording();
  /// Times recorded since start_recording().
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
  std::vector<Move> moves_;  ///< not shown yet; only while recording
  std::optional<Record> record_;
};

/// Percentile of the values by nearest rank; `share` in 0..1. Returns 0 without values.
double percentile(std::vector<double> values, double share);

}  // namespace simplexseg
