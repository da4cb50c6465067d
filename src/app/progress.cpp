// SPDX-License-Identifier: Apache-2.0
#include "app/progress.h"

#include <chrono>
#include <csignal>
#include <ostream>

namespace simplexseg {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;

void record_interrupt(int) {
  g_interrupted = 1;
  std::signal(SIGINT, SIG_DFL);
}

}  // namespace

Progress::Progress(const Console& console, std::string activity) : console_(console), activity_(std::move(activity)) {
  if (console_.shows_progress) thread_ = std::thread([this] { show(); });
}

Progress::~Progress() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Progress::show() {
  using namespace std::chrono;
  std::unique_lock lock(mutex_);
  const auto start = steady_clock::now();
  if (wake_.wait_for(lock, seconds(1), [this] { return done_; })) return;
  while (!done_) {
    const double share = share_;
    console_.err << "\r" << activity_ << " ... ";
    if (share >= 0) console_.err << static_cast<int>(100 * share) << "%, ";
    console_.err << duration_cast<seconds>(steady_clock::now() - start).count() << " s \x1b[K" << std::flush;
    wake_.wait_for(lock, milliseconds(250), [this] { return done_; });
  }
  console_.err << "\r\x1b[K" << std::flush;
}

Interrupt::Interrupt() {
  g_interrupted = 0;
  previous_ = std::signal(SIGINT, record_interrupt);
}

Interrupt::~Interrupt() { std::signal(SIGINT, previous_); }

void Interrupt::check() {
  if (g_interrupted) throw Failure("interrupted by Ctrl+C; files that were written before are complete");
}

}  // namespace simplexseg
