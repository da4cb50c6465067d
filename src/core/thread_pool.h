// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace simplexseg {

/// Lowers the priority of the calling thread below that of the threads for which the user waits. No effect except on
/// Linux, where each thread has a separate nice value.
void lower_thread_priority();

/// Runs the chunks of one job on a few threads, including the caller's. If the system wakes a worker too late, for
/// example because the workers compete with the threads that draw a window, the other threads run its chunks
/// (docs/adr/0004-threads.md). Chunks run in any order and must not depend on each other.
class ThreadPool {
 public:
  /// `threads`: number of threads including the caller's. `in_background`: workers run at a lower priority.
  explicit ThreadPool(int threads, bool in_background = false);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }
  /// Calls job(0) ... job(chunks - 1) and returns when all these calls have returned. Call it from one thread at a
  /// time; `job` must not throw.
  template <class Job>
  void run(int chunks, const Job& job) {
    run_erased(
        chunks, [](const void* j, int chunk) { (*static_cast<const Job*>(j))(chunk); }, &job);
  }

 private:
  using Call = void (*)(const void*, int);
  /// Current job and the range of chunks that one thread runs first, in one cache line.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> claims{0};  ///< generation << 32 | next chunk; claims fail once the job has changed
    std::atomic<std::uint32_t> end{0};
    std::atomic<Call> call{nullptr};
    std::atomic<const void*> job{nullptr};
    std::uint32_t generation() const {
      return static_cast<std::uint32_t>(claims.load(std::memory_order_acquire) >> 32);
    }
  };
  void run_erased(int chunks, Call call, const void* job);
  std::uint32_t run_chunks(int own);
  static bool run_one_chunk(Share& share);
  void work(int own);

  std::vector<std::thread> workers_;
  std::vector<Share> shares_;  ///< share of the caller, then one for each worker
  std::uint64_t generation_ = 0;
  std::uint32_t expected_ = 0;                          ///< value of `finished_` when all workers' chunks are done
  alignas(64) std::atomic<std::uint32_t> finished_{0};  ///< number of chunks finished by workers since construction
  alignas(64) std::atomic<std::uint32_t> signal_{0};    ///< incremented to wake the sleeping workers
  std::atomic<int> sleeping_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace simplexseg
