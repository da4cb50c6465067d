// SPDX-License-Identifier: Apache-2.0
#include "app/simulate.h"

#include <algorithm>
#include <chrono>

#include "app/progress.h"
#include "image/mask.h"
#include "session/log_replay.h"

namespace simplexseg {
namespace {

constexpr double kChunkSeconds = 0.1;  ///< target time between two checks for Ctrl+C, s

}  // namespace

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

TracedClock::TracedClock(const Session& session, const References* references)
    : session_(session), traces_(references != nullptr) {
  if (traces_) {
    for (const MeshItem& item : session.scene_without_poses().meshes)
      if (const std::optional<Mask> truth = references->mask_for(item))
        trace_.set_reference(item.id, std::make_shared<SurfaceError>(*truth));
  }
  start_ = seconds_now();
  sample(0);
}

int TracedClock::steps_until_sample(int steps) const {
  return traces_ ? std::min(steps, trace_.steps_until_due(session_.total_steps())) : steps;
}

void TracedClock::sample(double seconds) {
  if (!traces_ || session_.total_steps() == last_) return;
  const double at = seconds_now();
  trace_.sample(session_, seconds);
  last_ = session_.total_steps();
  sampling_ += seconds_now() - at;
}

void TracedClock::sample_if_due() {
  if (traces_ && trace_.due(session_.total_steps())) sample(seconds());
}

double TracedClock::stop() {
  const double at = seconds();
  sample(at);
  return at;
}

Advance simulate(Session& session, int steps, bool until_rest, TracedClock& clock, const Console& console) {
  Progress progress(console, "simulating");
  Advance total;
  int chunk = 1;
  while (total.steps < steps && !total.failure && !(until_rest && total.at_rest)) {
    Interrupt::check();
    const double start = seconds_now();
    const int count = clock.steps_until_sample(std::min(chunk, steps - total.steps));
    const Advance part = as_failure([&] { return session.advance_steps(count, until_rest); });
    const double took = seconds_now() - start;
    append(total, part);
    clock.sample_if_due();
    if (part.steps == 0) break;
    if (took < kChunkSeconds / 2) chunk = std::min(2 * chunk, 1 << 20);
    if (took > kChunkSeconds * 2) chunk = std::max(chunk / 2, 1);
    if (!until_rest) progress.set(static_cast<double>(total.steps) / steps);
  }
  return total;
}

Advance replay(Session& session, const LogFile& log, TracedClock& clock, const Console& console) {
  Progress progress(console, "replaying");
  Advance total;
  for (LogReplay replay(session, log.log, log.trailing_steps); !replay.done();) {
    Interrupt::check();
    if (replay.steps_left() == 0) {
      replay.execute_next();
    } else {
      if (total.failure) total.cuts.push_back(*total.failure);  // the recorded run continued after this failure
      append(total, as_failure([&] { return replay.advance(clock.steps_until_sample(replay.steps_left())); }));
      clock.sample_if_due();
    }
    progress.set(static_cast<double>(replay.commands_done()) / static_cast<double>(log.log.size() + 1));
  }
  return total;
}

}  // namespace simplexseg
