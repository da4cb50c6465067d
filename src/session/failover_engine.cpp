// SPDX-License-Identifier: Apache-2.0
#include "session/failover_engine.h"

#include "core/error.h"
#include "core/expect.h"

namespace simplexseg {

FailoverEngine::FailoverEngine(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback)
    : engine_(std::move(engine)), make_fallback_(std::move(make_fallback)) {
  SIMPLEXSEG_EXPECT(engine_ != nullptr);
}

std::unique_ptr<Engine> FailoverEngine::replace(std::unique_ptr<Engine> engine) {
  SIMPLEXSEG_EXPECT(engine != nullptr);
  std::swap(engine_, engine);
  failure_.reset();
  ++generation_;
  return engine;
}

void FailoverEngine::fail_over(const DeviceError& failure) {
  if (!make_fallback_) throw failure;
  notice_ = std::string("running on the CPU: ") + failure.what();
  engine_.reset();  // releases the memory of the failed engine first
  replace(make_fallback_());
  make_fallback_ = {};
}

void FailoverEngine::record_failure(const DeviceError& failure) {
  if (!make_fallback_) throw failure;
  failure_ = failure.what();
}

void FailoverEngine::append_to_notice(const std::string& text) {
  SIMPLEXSEG_EXPECT(notice_.has_value());
  *notice_ += text;
}

}  // namespace simplexseg
