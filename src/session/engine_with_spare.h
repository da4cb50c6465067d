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

/// The engine of a session, and the one that takes over, once, when the device of the first one fails.
class EngineWithSpare {
 public:
  /// `make_spare` may be empty: there is none then.
  EngineWithSpare(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_spare);

  Engine& operator*() const { return *engine_; }
  Engine* operator->() const { return engine_.get(); }

  /// Puts another engine in place, and returns the one before; the spare stays.
  std::unique_ptr<Engine> replace(std::unique_ptr<Engine> engine);
  /// Puts the spare in place, which is still empty, and makes the notice of it. Throws the failure again, with nothing
  /// changed, when there is none.
  void put_spare_in_place(const DeviceError& failure);
  /// Counts the engines that there were before this one.
  int generation() const { return generation_; }

  /// Remembers a failure for whoever may put the spare in place later. Throws it again when there is no spare.
  void note_loss(const DeviceError& failure);
  /// What the engine failed with: it is of no use any more.
  const std::optional<std::string>& loss() const { return loss_; }

  /// One line for the user, once: that the device failed and the session goes on without it.
  std::optional<std::string> take_notice() { return std::exchange(notice_, std::nullopt); }
  /// Ends the line that was made when the spare was put in place.
  void add_to_notice(const std::string& text);

 private:
  std::unique_ptr<Engine> engine_;
  std::function<std::unique_ptr<Engine>()> make_spare_;
  std::optional<std::string> notice_, loss_;
  int generation_ = 0;
};

}  // namespace simplexseg
