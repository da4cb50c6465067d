// SPDX-License-Identifier: Apache-2.0
#include "serve/lease.h"

#include <algorithm>
#include <cstdint>
#include <random>

#include "core/number_text.h"

namespace simplexseg {
namespace {

/// 128 random bits of the system, in hexadecimal.
std::string random_token() {
  std::random_device source;
  std::string token;
  for (int word = 0; word < 4; ++word) token += hexadecimal_text(static_cast<std::uint32_t>(source()), 8);
  return token;
}

}  // namespace

bool equal_secrets(const std::string& expected, const std::string& given) {
  unsigned difference = expected.size() == given.size() ? 0 : 1;
  for (std::size_t i = 0; i < given.size(); ++i)
    difference |= static_cast<unsigned char>(given[i]) ^
                  static_cast<unsigned char>(expected.empty() ? 0 : expected[i % expected.size()]);
  return difference == 0;
}

bool Lease::is_over(double now_s) const {
  return busy_ == 0 && (now_s - seen_s_ > times_.liveness_s || now_s - active_s_ > times_.idle_s);
}

std::optional<std::string> Lease::claim(double now_s) {
  const std::lock_guard lock(mutex_);
  if (!token_.empty() && !is_over(now_s)) return std::nullopt;
  token_ = random_token();
  active_s_ = seen_s_ = now_s;
  busy_ = 0;
  return token_;
}

bool Lease::use(const std::string& token, Use use, double now_s) {
  const std::lock_guard lock(mutex_);
  if (token_.empty() || !equal_secrets(token_, token) || is_over(now_s)) return false;
  if (use != Use::Peek) seen_s_ = now_s;
  if (use == Use::Action) active_s_ = now_s;
  return true;
}

bool Lease::release(const std::string& token) {
  const std::lock_guard lock(mutex_);
  if (token_.empty() || !equal_secrets(token_, token)) return false;
  token_.clear();
  busy_ = 0;
  return true;
}

bool Lease::expire(double now_s) {
  const std::lock_guard lock(mutex_);
  if (token_.empty() || !is_over(now_s)) return false;
  token_.clear();
  return true;
}

double Lease::remaining_s(double now_s) const {
  const std::lock_guard lock(mutex_);
  return token_.empty() ? 0 : std::max(0.0, times_.idle_s - (now_s - active_s_));
}

Lease::Busy::Busy(Lease& lease, double (*now_s)()) : lease_(lease), now_s_(now_s) {
  const std::lock_guard lock(lease_.mutex_);
  token_ = lease_.token_;
  ++lease_.busy_;
}

Lease::Busy::~Busy() {
  const std::lock_guard lock(lease_.mutex_);
  if (lease_.token_ != token_) return;  // another lease, which does not count this request
  --lease_.busy_;
  lease_.active_s_ = lease_.seen_s_ = now_s_();
}

}  // namespace simplexseg
