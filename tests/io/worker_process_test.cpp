// SPDX-License-Identifier: Apache-2.0
#include "io/platform/worker_process.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <csignal>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace simplexseg {
namespace {

/// Returns true when the worker still reports after it ran `before`.
bool survives(const std::function<void()>& before, const WorkerLimits& limits = {}) {
  WorkerProcess worker(limits, [&](int pipe) {
    before();
    write_to_parent(pipe, "x", 1);
  });
  char byte = 0;
  return worker.read(&byte, 1) && byte == 'x';
}

TEST(WorkerProcess, OutputArrivesInOrder) {
  const std::string text(5000000, 'a');  // more than the capacity of a pipe
  WorkerProcess worker({}, [&](int pipe) {
    write_to_parent(pipe, text.data(), text.size());
    write_to_parent(pipe, "end", 3);
  });
  std::string read(text.size() + 3, '\0');
  ASSERT_TRUE(worker.read(read.data(), read.size()));
  EXPECT_EQ(read, text + "end");
  EXPECT_FALSE(worker.read(read.data(), 1)) << "end of the output";
}

TEST(WorkerProcess, ACrashEndsOnlyTheWorker) {
  EXPECT_TRUE(survives([] {}));
  EXPECT_FALSE(survives([] { std::abort(); }));
  EXPECT_FALSE(survives([] { ::raise(SIGSEGV); }));
  EXPECT_FALSE(survives([] { std::exit(0); }));
  EXPECT_FALSE(survives([] { throw 1; }));
}

TEST(WorkerProcess, MemoryAndTimeAreLimited) {
  const auto takes = [](std::size_t bytes) {
    return [bytes] {
      if (::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED)
        std::_Exit(1);
    };
  };
  EXPECT_TRUE(survives(takes(100 << 20)));
  EXPECT_FALSE(survives(takes(400 << 20)));
  EXPECT_TRUE(survives(takes(400 << 20), {.memory_bytes = 600 << 20}));
  EXPECT_FALSE(survives(
      [] {
        for (std::atomic<unsigned> n = 0;; ++n) {
        }
      },
      {.cpu_seconds = 1}));
  EXPECT_FALSE(survives([] { ::sleep(3600); }, {.cpu_seconds = 0, .min_idle_timeout_s = 1}));
}

TEST(WorkerProcess, TemporaryFilesAreDeleted) {
  std::string folder(4096, '\0');
  {
    WorkerProcess worker({}, [&](int pipe) {
      std::string name = std::getenv("TMPDIR");
      std::ofstream(name + "/left") << "over";
      name.resize(4096, '\0');
      write_to_parent(pipe, name.data(), name.size());
    });
    ASSERT_TRUE(worker.read(folder.data(), folder.size()));
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(folder.c_str()) / "left"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.c_str()));
}

}  // namespace
}  // namespace simplexseg
