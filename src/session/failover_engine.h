// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "step/engine.h"

namespace simplexseg {

class DeviceError;

/// Engine of a session. If its device fails, a fallback engine replaces it, at most once.
class FailoverEngine {
 public:
  /// `make_fallback`: makes the fallback engine; empty: no fallback.
  FailoverEngine(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback);

  Engine& operator*() const { return *engine_; }
  Engine* operator->() const { return engine_.get(); }

  /// Replaces the engine, clears the recorded failure and returns the previous engine. The fallback remains available.
  std::unique_ptr<Engine> replace(std::unique_ptr<Engine> engine);
  /// Replaces the engine with the fallback, into which the caller must load the scene, and sets the notice. Without a
  /// fallback, throws `failure` and changes nothing.
  void fail_over(const DeviceError& failure);
  /// Number of engines that were used before the current one.
  int generation() const { return generation_; }

  /// Records a failure for a later fail_over(). Without a fallback, throws `failure`.
  void record_failure(const DeviceError& failure);
  /// Message of the recorded failure, after which the current engine can no longer be used; none: no failure.
  const std::optional<std::string>& failure() const { return failure_; }

  /// Removes and returns the message to the user that the device failed and the session continues on the fallback;
  /// none: no failover since the last call.
  std::optional<std::string> pop_notice() { return std::exchange(notice_, std::nullopt); }
  /// Appends text to the notice that fail_over() has set.
  void append_to_notice(const std::string& text);

 private:
  std::unique_ptr<Engine> engine_;
  std::function<std::unique_ptr<Engine>()> make_fallback_;
  std::optional<std::string> notice_, failure_;
  int generation_ = 0;
};

}  // namespace simplexseg
