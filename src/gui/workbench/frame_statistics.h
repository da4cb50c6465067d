// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

namespace simplexseg {

/// Frames of a while, in seconds.
struct FrameRecord {
  std::vector<double> frame_s;     ///< between two pictures
  std::vector<double> latency_s;   ///< from the mouse to the picture with the moved point
  std::vector<double> response_s;  ///< from the mouse to the picture after a step that knew of it
  long steps = 0;
  double step_seconds = 0;  ///< spent in these steps
};

/// How often a new picture is shown, how many steps lie between two, and how long a moved attraction point takes to be
/// seen. Told of each event in the order in which they happen. Times in seconds, of now_s().
class FrameStatistics {
 public:
  static double now_s();

  void steps_done(int steps, double seconds);
  /// A point has moved because of a movement of the mouse at `since_s`.
  void point_moved(double since_s);
  /// The views begin to paint what is so far.
  void painted();
  /// What was painted is on the screen. Told once for each view; true the first time.
  bool shown(double now_s);
  /// Nothing was to be shown for a while: the time since the last picture counts for nothing.
  void interrupt() { last_shown_s_.reset(); }

  /// Smoothed over some frames; 0 before there are any.
  double frames_per_second() const { return interval_s_ > 0 ? 1 / interval_s_ : 0; }
  double steps_per_frame() const { return steps_per_frame_; }

  /// What was recorded since start_recording().
  using Record = FrameRecord;
  void start_recording();
  Record stop_recording();

 private:
  struct Move {
    double since_s;
    bool stepped = false, painted = false, painted_after_step = false, shown = false;
  };
  bool picture_waits_ = false;
  std::optional<double> last_shown_s_;
  double interval_s_ = 0, steps_per_frame_ = 0;
  int steps_since_shown_ = 0;
  std::vector<Move> moves_;  ///< not answered yet; only while recording
  std::optional<Record> record_;
};

/// The value below which a share (0..1) of all lie (nearest rank); 0 when there are none.
double percentile(std::vector<double> values, double share);

}  // namespace simplexseg
