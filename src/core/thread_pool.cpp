// SPDX-License-Identifier: Apache-2.0
#include "core/thread_pool.h"

#include <algorithm>

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
/// Number of pauses, about 50 us: longer than the gap between two kernels of a step, shorter than a time slice.
constexpr int kSpins = 2000;

#if defined(__linux__)
/// Nice value at which a thread gets about a tenth of the CPU share of a thread of normal priority.
constexpr int kNice = 10;
#endif

}  // namespace

void lower_thread_priority() {
#if defined(__linux__)
  (void)setpriority(PRIO_PROCESS, 0, kNice);  // affects this thread only, see setpriority(2)
#endif
}

ThreadPool::ThreadPool(int threads, bool in_background) : shares_(static_cast<std::size_t>(std::max(threads, 1))) {
  for (int k = 1; k < threads; ++k)
    workers_.emplace_back([this, k, in_background] {
      if (in_background) lower_thread_priority();
      work(k);
    });
}

ThreadPool::~ThreadPool() {
  stop_ = true;
  signal_.fetch_add(1);
  signal_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

bool ThreadPool::run_one_chunk(Share& share) {
  std::uint64_t claim = share.claims.load(std::memory_order_acquire);
  for (;;) {
    const std::uint32_t chunk = static_cast<std::uint32_t>(claim);
    const Call call = share.call.load(std::memory_order_acquire);
    const void* job = share.job.load(std::memory_order_acquire);
    if (chunk >= share.end.load(std::memory_order_acquire)) return false;
    // Succeeds only if no other job was published since `claim` was read, so `call` and `job` belong to the claim.
    if (share.claims.compare_exchange_weak(claim, claim + 1, std::memory_order_acq_rel, std::memory_order_acquire)) {
      call(job, static_cast<int>(chunk));
      return true;
    }
  }
}

/// Runs the unclaimed chunks of the thread's own share, then those of the other shares. Returns the number of chunks
/// run.
std::uint32_t ThreadPool::run_chunks(int own) {
  const std::size_t count = shares_.size();
  std::uint32_t taken = 0;
  for (std::size_t k = 0; k < count; ++k)
    while (run_one_chunk(shares_[(static_cast<std::size_t>(own) + k) % count])) ++taken;
  return taken;
}

void ThreadPool::run_erased(int chunks, Call call, const void* job) {
  if (chunks <= 0) return;
  if (chunks == 1 || workers_.empty()) {  // no worker has to be woken
    for (int chunk = 0; chunk < chunks; ++chunk) call(job, chunk);
    return;
  }
  ++generation_;
  const std::uint64_t count = shares_.size();
  for (std::uint64_t k = count; k-- > 0;) {  // the caller's own share last
    Share& share = shares_[k];
    const std::uint64_t first = k * static_cast<std::uint64_t>(chunks) / count,
                        end = (k + 1) * static_cast<std::uint64_t>(chunks) / count;
    // No chunk can be claimed while the job is exchanged, since `end` is 0. The last store makes the chunks available.
    share.end.store(0, std::memory_order_release);
    share.call.store(call, std::memory_order_release);
    share.job.store(job, std::memory_order_release);
    share.claims.store(generation_ << 32 | first, std::memory_order_release);
    share.end.store(static_cast<std::uint32_t>(end), std::memory_order_release);
  }
  // A read-modify-write instead of a load: a worker that falls asleep later sees the job, and one that fell asleep
  // earlier is counted.
  if (sleeping_.fetch_add(0) > 0) signal_.fetch_add(1), signal_.notify_all();
  expected_ += static_cast<std::uint32_t>(chunks) - run_chunks(0);
  for (int spin = 0; finished_.load(std::memory_order_acquire) != expected_; ++spin)
    spin < kSpins ? pause() : std::this_thread::yield();
}

void ThreadPool::work(int own) {
  const Share& share = shares_[static_cast<std::size_t>(own)];
  std::uint32_t seen = 0;
  while (!stop_) {
    for (int spin = 0; share.generation() == seen && spin < kSpins && !stop_; ++spin) pause();
    if (share.generation() == seen) {
      sleeping_.fetch_add(1);
      const std::uint32_t signal = signal_.load();
      if (share.generation() == seen && !stop_) signal_.wait(signal);
      sleeping_.fetch_sub(1);
    }
    seen = share.generation();
    if (const std::uint32_t taken = run_chunks(own); taken > 0) finished_.fetch_add(taken, std::memory_order_acq_rel);
  }
}

}  // namespace simplexseg
