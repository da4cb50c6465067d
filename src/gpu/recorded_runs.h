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

/// Where in its cycles an engine is: what a run of steps begins with, besides the plan, and what it leaves behind.
struct StepPhase {
  int oldest = 0;  ///< of the three position arrays: previous, current, next from here on
  int frame = 0;   ///< of two arrays of frames, the one that holds them
  int since_refresh = 0;
  bool refresh_due = true, stiffness_due = false;
  bool measured_at_refresh = false;  ///< the motion that was measured last: in a step that found targets anew
};

/// Whether kernels see the same arrays; the three of positions, and those of frames, take turns.
inline bool same_addresses(StepView a, StepView b) {
  a.previous = b.previous, a.current = b.current, a.next = b.next, a.oldest = b.oldest;
  a.frame = b.frame, a.new_frame = b.new_frame;
  static_assert(std::is_trivially_copyable_v<StepView>);
  return std::memcmp(&a, &b, sizeof a) == 0;
}

/// Runs of steps, recorded when they come again, and then repeated at small cost. Where the executor cannot, they are
/// done.
template <class Executor>
class RecordedRuns {
 public:
  /// After anything that a recorded run has in it has changed: addresses, plan.
  void clear() { runs_.clear(); }

  /// `steps()` does the run and changes `phase`. Returns how many steps were done before a
  /// failure that the host knows of.
  template <class Steps>
  int run(Launcher<Executor>& launcher, StepPhase& phase, int refresh_interval, int length, End end, Steps&& steps) {
    if constexpr (!Executor::kRecords) {
      return steps();
    } else {
      // Runs in which nothing is found anew are alike, however long ago it was.
      const int until_refresh = phase.refresh_due ? 0 : std::clamp(refresh_interval - phase.since_refresh, 0, length);
      const int since_refresh = phase.since_refresh;
      const Key key{phase.oldest, phase.frame, until_refresh, phase.stiffness_due, length, end};
      auto found = runs_.find(key);
      if (found == runs_.end()) {
        // Recording costs as much as many launches: only what comes again is worth it.
        constexpr std::size_t kMostRuns = 200;
        if (runs_.size() >= kMostRuns) forget_one();
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
          const std::uint64_t more = n - (was == before.end() ? 0 : was->second);
          if (more != 0) run.launches[name] = more;
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
    std::uint64_t used = 0;  ///< when: counts all uses
  };
  /// That which has not come for longest. All of them at once would hold up a frame.
  void forget_one() {
    runs_.erase(std::min_element(runs_.begin(), runs_.end(),
                                 [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  std::map<Key, Run> runs_;
  std::uint64_t uses_ = 0;
};

}  // namespace simplexseg
