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

/// Engine of a session, with one fallback that replaces it when its device fails.
class FailoverEngine {
 public:
  /// `make_fallback`: makes the fallback; empty: there is none.
  FailoverEngine(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback);

  Engine& operator*() const { return *engine_; }
  Engine* operator->() const { return engine_.get(); }

  /// Replaces the engine and returns the previous one; the fallback stays available.
  std::unique_ptr<Engine> replace(std::unique_ptr<Engine> engine);
  /// Replaces the engine with the fallback, which has no scene yet, and sets the notice. Without a fallback, rethrows
  /// the failure and changes nothing.
  void fail_over(const DeviceError& failure);
  /// Number of engines before this one.
  int generation() const { return generation_; }

  /// Records a failure for a later fail_over(). Rethrows it without a fallback.
  void record_failure(const DeviceError& failure);
  /// Recorded failure; an engine that has one can no longer be used.
  const std::optional<std::string>& failure() const { return failure_; }

  /// Removes and returns the message to the user that the device failed and the session continues on the fallback.
  std::optional<std::string> pop_notice() { return std::exchange(notice_, std::nullopt); }
  /// Appends text to the notice of fail_over().
  void append_to_notice(const std::string& text);

 private:
  std::unique_ptr<Engine> engine_;
  std::function<std::unique_ptr<Engine>()> make_fallback_;
  std::optional<std::string> notice_, failure_;
  int generation_ = 0;
};

}  // namespace simplexseg
