// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <compare>
#include <cstring>
#include <map>
#include <string_view>
#include <type_traits>

#include "gpu/kernels.h"
#include "gpu/launcher.h"

namespace simplexseg {

/// State of an engine between runs of steps: current indices of the arrays used in rotation, and work that is due.
struct StepPhase {
  int oldest = 0;         ///< index of the previous positions in the cycle of three arrays: previous, current, next
  int frame = 0;          ///< index of the array with the current frames, 0 or 1
  int since_refresh = 0;  ///< number of steps since the last refresh
  bool refresh_due = true, stiffness_due = false;
  bool measured_at_refresh = false;  ///< true if the last measured step updated the targets
};

/// True if two views are identical, except for positions and frames, whose arrays are used in rotation.
inline bool same_addresses(StepView a, StepView b) {
  a.previous = b.previous, a.current = b.current, a.next = b.next, a.oldest = b.oldest;
  a.frame = b.frame, a.new_frame = b.new_frame;
  static_assert(std::is_trivially_copyable_v<StepView>);
  return std::memcmp(&a, &b, sizeof a) == 0;
}

/// Cache of recorded runs of steps. A run is recorded when it is requested for the second time, and replayed from then
/// on. On an executor without recording, every run is executed directly.
template <class Executor>
class RecordedRuns {
 public:
  /// Discards all recordings; required after a change of array addresses or of the sequence of kernels.
  void clear() { runs_.clear(); }

  /// Runs `length` steps, the last of which ends the unit `end`; `steps()` executes them and updates `phase`. Returns
  /// the number of steps before a failure if the executor reports failures at once, else `length`.
  template <class Steps>
  int run(Launcher<Executor>& launcher, StepPhase& phase, int refresh_interval, int length, End end, Steps&& steps) {
    if constexpr (!Executor::kRecords) {
      return steps();
    } else {
      // Runs without a refresh share one recording, for any number of steps since the last refresh.
      const int until_refresh = phase.refresh_due ? 0 : std::clamp(refresh_interval - phase.since_refresh, 0, length);
      const int since_refresh = phase.since_refresh;
      const Key key{phase.oldest, phase.frame, until_refresh, phase.stiffness_due, length, end};
      auto found = runs_.find(key);
      if (found == runs_.end()) {
        // Recording takes as long as many launches, so only repeated runs are recorded.
        constexpr std::size_t kMaxRuns = 200;
        if (runs_.size() >= kMaxRuns) evict_least_recent();
        runs_[key].used = ++uses_;
        return steps();
      }
      Run& run = found->second;
      run.used = ++uses_;
      if (!run.recorded) {
        const auto before = launcher.launches;
        run.recording = launcher.executor.record([&] { steps(); });
        run.after = phase;
        for (const auto& [name, n] : launcher.launches) {
          const auto was = before.find(name);
          const std::uint64_t added = n - (was == before.end() ? 0 : was->second);
          if (added != 0) run.launches[name] = added;
        }
        run.recorded = true;
      } else {
        phase = run.after;
        if (until_refresh == length) phase.since_refresh = since_refresh + length;
        for (const auto& [name, n] : run.launches) launcher.launches[name] += n;
      }
      launcher.executor.replay(run.recording);
      return length;
    }
  }

 private:
  struct Key {
    int oldest, frame, until_refresh;
    bool stiffness_due;
    int length;
    End end;
    auto operator<=>(const Key&) const = default;
  };
  struct Run {
    bool recorded = false;
    typename Executor::Recording recording;
    StepPhase after;
    std::map<std::string_view, std::uint64_t> launches;
    std::uint64_t used = 0;  ///< value of uses_ at the last use
  };
  /// Removes the least recently used run. Removing all runs at once would delay the next frame.
  void evict_least_recent() {
    runs_.erase(std::min_element(runs_.begin(), runs_.end(),
                                 [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  std::map<Key, Run> runs_;
  std::uint64_t uses_ = 0;
};

}  // namespace simplexseg
