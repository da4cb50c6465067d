// SPDX-License-Identifier: Apache-2.0
#include "session/engine_with_spare.h"

#include "core/error.h"
#include "core/expect.h"

namespace simplexseg {

EngineWithSpare::EngineWithSpare(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_spare)
    : engine_(std::move(engine)), make_spare_(std::move(make_spare)) {
  SIMPLEXSEG_EXPECT(engine_ != nullptr);
}

std::unique_ptr<Engine> EngineWithSpare::replace(std::unique_ptr<Engine> engine) {
  SIMPLEXSEG_EXPECT(engine != nullptr);
  std::swap(engine_, engine);
  loss_.reset();
  ++generation_;
  return engine;
}

void EngineWithSpare::put_spare_in_place(const DeviceError& failure) {
  if (!make_spare_) throw failure;
  notice_ = std::string("running on the CPU: ") + failure.what();
  engine_.reset();  // its memory first
  replace(make_spare_());
  make_spare_ = {};
}

void EngineWithSpare::note_loss(const DeviceError& failure) {
  if (!make_spare_) throw failure;
  loss_ = failure.what();
}

void EngineWithSpare::add_to_notice(const std::string& text) {
  SIMPLEXSEG_EXPECT(notice_.has_value());
  *notice_ += text;
}

}  // namespace simplexseg
