// SPDX-License-Identifier: Apache-2.0
#include "core/thread_pool.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif
#if defined(__linux__)
#include <sys/resource.h>
#endif

namespace simplexseg {
namespace {

void pause() {
#if defined(__x86_64__)
  _mm_pause();
#endif
}
/// About 50 us: longer than the gap between two kernels of a step, shorter than a time slice.
constexpr int kSpins = 2000;

#if defined(__linux__)
/// A tenth of the share of a thread that has not stepped back, and all that others leave.
constexpr int kNice = 10;
#endif

}  // namespace

void step_back() {
#if defined(__linux__)
  (void)setpriority(PRIO_PROCESS, 0, kNice);  // of this thread alone, setpriority(2) says; a refusal changes nothing
#endif
}

ThreadPool::ThreadPool(int threads, bool in_background) {
  for (int k = 1; k < threads; ++k)
    workers_.emplace_back([this, in_background] {
      if (in_background) step_back();
      work();
    });
}

ThreadPool::~ThreadPool() {
  stop_ = true;
  signal_.fetch_add(1);
  signal_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

bool ThreadPool::take_one() {
  std::uint64_t claim = claims_.load(std::memory_order_acquire);
  for (;;) {
    const std::uint32_t chunk = static_cast<std::uint32_t>(claim);
    const Call call = call_.load(std::memory_order_acquire);
    const void* job = job_.load(std::memory_order_acquire);
    if (chunk >= chunks_.load(std::memory_order_acquire)) return false;
    // Succeeds only when no other job was published since `claim` was read, so call and job belong to it.
    if (claims_.compare_exchange_weak(claim, claim + 1, std::memory_order_acq_rel, std::memory_order_acquire)) {
      call(job, static_cast<int>(chunk));
      finished_.fetch_add(1, std::memory_order_acq_rel);
      return true;
    }
  }
}

void ThreadPool::run_erased(int chunks, Call call, const void* job) {
  if (chunks <= 0) return;
  if (chunks == 1 || workers_.empty()) {  // nobody need be woken
    for (int chunk = 0; chunk < chunks; ++chunk) call(job, chunk);
    return;
  }
  // No chunk is left of the last job, so nobody claims while the job is exchanged; the new generation opens it.
  finished_.store(0, std::memory_order_relaxed);
  const std::uint64_t generation = (claims_.load(std::memory_order_relaxed) >> 32) + 1;
  chunks_.store(0, std::memory_order_release);
  call_.store(call, std::memory_order_release);
  job_.store(job, std::memory_order_release);
  claims_.store(generation << 32, std::memory_order_release);
  chunks_.store(static_cast<std::uint32_t>(chunks), std::memory_order_release);
  signal_.fetch_add(1);
  if (sleeping_.load() > 0) signal_.notify_all();
  while (take_one()) {
  }
  for (int spin = 0; finished_.load(std::memory_order_acquire) != static_cast<std::uint32_t>(chunks); ++spin)
    spin < kSpins ? pause() : std::this_thread::yield();
}

void ThreadPool::work() {
  std::uint32_t seen = signal_.load();
  while (!stop_) {
    while (take_one()) {
    }
    int spin = 0;
    while (signal_.load(std::memory_order_acquire) == seen && spin < kSpins) ++spin, pause();
    if (signal_.load() == seen) {
      sleeping_.fetch_add(1);
      signal_.wait(seen);
      sleeping_.fetch_sub(1);
    }
    seen = signal_.load();
  }
}

}  // namespace simplexseg
