// SPDX-License-Identifier: Apache-2.0
#include "serve/lease.h"

#include <gtest/gtest.h>

namespace simplexseg {
namespace {

double g_now_s = 0;
double test_clock() { return g_now_s; }

TEST(LeaseTest, OnlyOneClientHasIt) {
  Lease lease({600, 60});
  const auto first = lease.claim(0);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->size(), 32u);
  EXPECT_FALSE(lease.claim(1));
  EXPECT_FALSE(lease.use("", Lease::Use::Action, 1));
  EXPECT_FALSE(lease.use(*first + "0", Lease::Use::Action, 1));
  EXPECT_TRUE(lease.release(*first));
  EXPECT_FALSE(lease.release(*first));
  const auto second = lease.claim(2);
  ASSERT_TRUE(second);
  EXPECT_NE(*first, *second);
  EXPECT_FALSE(lease.use(*first, Lease::Use::Action, 2));
}

TEST(LeaseTest, HeartbeatsProlongLivenessAlone) {
  Lease lease({100, 10});
  const std::string token = lease.claim(0).value();
  for (double now = 8; now < 100; now += 8) EXPECT_TRUE(lease.use(token, Lease::Use::Alive, now)) << now;
  EXPECT_NEAR(lease.remaining_s(96), 4, 1e-9);
  EXPECT_FALSE(lease.use(token, Lease::Use::Alive, 101)) << "idle";
  EXPECT_TRUE(lease.expire(101));
  EXPECT_FALSE(lease.expire(101));
}

TEST(LeaseTest, ASilentClientLosesItAndAProbeDoesNotProlongIt) {
  Lease lease({100, 10});
  const std::string token = lease.claim(0).value();
  EXPECT_TRUE(lease.use(token, Lease::Use::Peek, 9));
  EXPECT_FALSE(lease.use(token, Lease::Use::Action, 11));
  EXPECT_TRUE(lease.claim(11)) << "another client may have it";
}

TEST(LeaseTest, DoesNotExpireWhileARequestIsProcessed) {
  Lease lease({100, 10});
  const std::string token = lease.claim(0).value();
  g_now_s = 50;
  {
    const Lease::Busy busy(lease, &test_clock);
    EXPECT_FALSE(lease.expire(50));
    EXPECT_FALSE(lease.claim(50));
  }
  EXPECT_TRUE(lease.use(token, Lease::Use::Alive, 59)) << "the end of the request restarts the clocks";
  EXPECT_TRUE(lease.expire(70));
}

TEST(LeaseTest, SecretsAreEqualOnlyAsAWhole) {
  EXPECT_TRUE(equal_secrets("abc", "abc"));
  for (const char* const other : {"", "ab", "abd", "abcabc", "abca"})
    EXPECT_FALSE(equal_secrets("abc", other)) << other;
  EXPECT_FALSE(equal_secrets("", "x"));
}

}  // namespace
}  // namespace simplexseg
