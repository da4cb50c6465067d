// SPDX-License-Identifier: Apache-2.0
#include "io/child_process.h"

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

/// Whether the child says that it is there, after `before`.
bool lives(const std::function<void()>& before, const ChildLimits& limits = {}) {
  ChildProcess child(limits, [&](int pipe) {
    before();
    write_to_parent(pipe, "x", 1);
  });
  char said = 0;
  return child.read(&said, 1) && said == 'x';
}

TEST(ChildProcess, WhatItWritesComesBackInOrder) {
  const std::string text(5000000, 'a');  // more than a pipe holds
  ChildProcess child({}, [&](int pipe) {
    write_to_parent(pipe, text.data(), text.size());
    write_to_parent(pipe, "end", 3);
  });
  std::string read(text.size() + 3, '\0');
  ASSERT_TRUE(child.read(read.data(), read.size()));
  EXPECT_EQ(read, text + "end");
  EXPECT_FALSE(child.read(read.data(), 1)) << "there is no more";
}

TEST(ChildProcess, WhateverEndsItEndsItAlone) {
  EXPECT_TRUE(lives([] {}));
  EXPECT_FALSE(lives([] { std::abort(); }));
  EXPECT_FALSE(lives([] { ::raise(SIGSEGV); }));
  EXPECT_FALSE(lives([] { std::exit(0); }));
  EXPECT_FALSE(lives([] { throw 1; }));
}

TEST(ChildProcess, MemoryAndTimeAreLimited) {
  const auto takes = [](std::size_t bytes) {
    return [bytes] {
      if (::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED)
        std::_Exit(1);
    };
  };
  EXPECT_TRUE(lives(takes(100 << 20)));
  EXPECT_FALSE(lives(takes(400 << 20)));
  EXPECT_TRUE(lives(takes(400 << 20), {.memory_bytes = 600 << 20}));
  EXPECT_FALSE(lives(
      [] {
        for (std::atomic<unsigned> n = 0;; ++n) {
        }
      },
      {.cpu_seconds = 1}));
  EXPECT_FALSE(lives([] { ::sleep(3600); }, {.cpu_seconds = 0, .least_silent_seconds = 1}));
}

TEST(ChildProcess, ItsTemporaryFilesGoWithIt) {
  std::string folder(4096, '\0');
  {
    ChildProcess child({}, [&](int pipe) {
      std::string name = std::getenv("TMPDIR");
      std::ofstream(name + "/left") << "over";
      name.resize(4096, '\0');
      write_to_parent(pipe, name.data(), name.size());
    });
    ASSERT_TRUE(child.read(folder.data(), folder.size()));
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(folder.c_str()) / "left"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.c_str()));
}

}  // namespace
}  // namespace simplexseg
