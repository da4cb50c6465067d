// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <string>

#include "forces/force_list.h"

namespace simplexseg {
namespace {

TEST(ForceList, NamesEachForceOnceAndFindsIt) {
  std::set<std::string> names, titles;
  for (const ForceInfo& force : force_list()) {
    EXPECT_TRUE(names.insert(force.name).second) << force.name;
    EXPECT_TRUE(titles.insert(force.title).second) << force.title;
    ASSERT_NE(find_force(force.name), nullptr) << force.name;
    EXPECT_EQ(find_force(force.name)->id, force.id);
    EXPECT_STREQ(force.parameters[0].name, "weight") << force.name;
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kForceCount));
  EXPECT_EQ(find_force("no such force"), nullptr);
}

TEST(ForceList, SetsOfForcesMatchTheirHeaders) {
  for (const ForceInfo& force : force_list()) {
    EXPECT_EQ((kInternalForces & bit(force.id)) != 0, force.kind == ForceKind::Internal) << force.name;
    EXPECT_EQ((kImageForces & bit(force.id)) != 0, force.kind == ForceKind::Image) << force.name;
    EXPECT_EQ((kForcesWithTargets & bit(force.id)) != 0, force.targets != nullptr) << force.name;
  }
  EXPECT_EQ(kInternalForces & kImageForces, 0u);
  EXPECT_EQ(kPullingForces & (kInternalForces | kImageForces), 0u);
  EXPECT_NE(kPullingForces, 0u);
}

TEST(ForceList, HasTheAdditionalForceOfThisBuild) {
  const char* expected = std::getenv("SIMPLEXSEG_EXPECTED_FORCE");
  if (expected == nullptr) GTEST_SKIP() << "skipped: built without an additional force (tests/toy_force/check sets it)";
  EXPECT_NE(find_force(expected), nullptr) << expected;
}

}  // namespace
}  // namespace simplexseg
