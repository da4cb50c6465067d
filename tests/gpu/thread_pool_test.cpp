// SPDX-License-Identifier: Apache-2.0
#include "core/thread_pool.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

namespace simplexseg {
namespace {

TEST(ThreadPoolTest, EachChunkRunsOnceOnAnyNumberOfThreads) {
  for (int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    for (int round = 0; round < 400; ++round) {
      const int chunks = 1 + (round * 7) % 300;
      std::vector<int> done(static_cast<std::size_t>(chunks), 0);
      pool.run(chunks, [&](int chunk) { ++done[static_cast<std::size_t>(chunk)]; });
      for (int times : done) ASSERT_EQ(times, 1) << threads << " threads, round " << round;
      if (round % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));  // workers go to sleep
    }
  }
}

/// The pool does not wait for a slow worker: here the second one is delayed by its first chunk.
TEST(ThreadPoolTest, OtherThreadsRunTheChunksOfADelayedWorker) {
  ThreadPool pool(2);
  constexpr int kChunks = 16;
  std::vector<std::thread::id> by(kChunks);
  const auto caller = std::this_thread::get_id();
  pool.run(kChunks, [&](int chunk) {
    by[static_cast<std::size_t>(chunk)] = std::this_thread::get_id();
    if (std::this_thread::get_id() != caller) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  });
  int of_caller = 0;
  for (const std::thread::id& id : by) of_caller += id == caller;
  EXPECT_GE(of_caller, kChunks - 2);
}

}  // namespace
}  // namespace simplexseg
