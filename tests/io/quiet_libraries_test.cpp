// SPDX-License-Identifier: Apache-2.0
#include "io/platform/quiet_libraries.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace simplexseg {
namespace {

void abort_as_a_library_does() { std::abort(); }

TEST(WithoutAborting, AbortBecomesAnException) {
  const QuietLibraries quiet;
  for (int again = 0; again < 3; ++again) EXPECT_THROW(without_aborting(abort_as_a_library_does), std::runtime_error);
}

TEST(WithoutAborting, NestedCallsKeepTheOuterHandler) {
  const QuietLibraries quiet;
  bool came_back = false;
  EXPECT_THROW(without_aborting([&] {
                 EXPECT_THROW(without_aborting(abort_as_a_library_does), std::runtime_error);
                 EXPECT_THROW(without_aborting([] { throw std::out_of_range("its own"); }), std::out_of_range);
                 came_back = true;
                 std::abort();
               }),
               std::runtime_error);
  EXPECT_TRUE(came_back);
}

TEST(WithoutAborting, ThePreviousHandlerIsRestored) {
  struct sigaction before {
  }, after{};
  ::sigaction(SIGABRT, nullptr, &before);
  EXPECT_THROW(without_aborting(abort_as_a_library_does), std::runtime_error);
  ::sigaction(SIGABRT, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
}

TEST(WithoutAbortingDeathTest, OutsideAbortEndsTheProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        try {
          without_aborting(abort_as_a_library_does);
        } catch (const std::runtime_error&) {
        }
        std::abort();
      },
      ::testing::KilledBySignal(SIGABRT), "");
}

}  // namespace
}  // namespace simplexseg
