// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace simplexseg {

/// From here on the calling thread leaves the processor to those of the program that the user waits for. On Linux
/// alone, where threads have a nice value of their own; elsewhere nothing changes.
void step_back();

/// Runs chunks of one job on a few threads, the caller's among them. A worker that the system has not woken in time is
/// not waited for: the others take its chunks. That is what a window needs, whose threads compete with the drawing
/// (docs/adr/0004-threads.md). Chunks may run in any order; a job's chunks must not depend on each other.
class ThreadPool {
 public:
  /// `threads` counts the caller: 1 starts none. `in_background`: they step_back().
  explicit ThreadPool(int threads, bool in_background = false);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }
  /// Calls job(0) ... job(chunks - 1) and returns when all have returned. From one thread at a time; jobs must not
  /// throw.
  template <class Job>
  void run(int chunks, const Job& job) {
    run_erased(
        chunks, [](const void* j, int chunk) { (*static_cast<const Job*>(j))(chunk); }, &job);
  }

 private:
  using Call = void (*)(const void*, int);
  /// The job at hand as one thread sees it, and the chunks of it that the thread takes first: all in one cache line,
  /// which comes to the thread at once.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> claims{0};  ///< generation << 32 | next chunk: succeeds only while its job is the one
    std::atomic<std::uint32_t> end{0};
    std::atomic<Call> call{nullptr};
    std::atomic<const void*> job{nullptr};
    std::uint32_t generation() const {
      return static_cast<std::uint32_t>(claims.load(std::memory_order_acquire) >> 32);
    }
  };
  void run_erased(int chunks, Call call, const void* job);
  std::uint32_t take_all(int own);
  static bool take_one(Share& share);
  void work(int own);

  std::vector<std::thread> workers_;
  std::vector<Share> shares_;  ///< of the caller, then of each worker
  std::uint64_t generation_ = 0;
  std::uint32_t expected_ = 0;                          ///< of `finished_`, once no worker holds a chunk
  alignas(64) std::atomic<std::uint32_t> finished_{0};  ///< chunks that workers have done, ever
  alignas(64) std::atomic<std::uint32_t> signal_{0};    ///< what sleeping workers wait on
  std::atomic<int> sleeping_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace simplexseg
