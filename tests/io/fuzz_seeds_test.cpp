// SPDX-License-Identifier: Apache-2.0
// Reads the fuzzer's seeds and findings, and randomly damaged seeds for compilers without a fuzzer.
#include "fuzz/check_seeds.h"
#include "fuzz/targets.h"

namespace simplexseg {
namespace {

class FuzzSeeds : public test::SeedsTest {};

TEST_P(FuzzSeeds, SeedsAreReadAndFindingsReadOrRejected) { check_seeds(); }
TEST_P(FuzzSeeds, DamagedSeedsGiveOneLineErrors) { check_damaged_seeds(); }

INSTANTIATE_TEST_SUITE_P(Readers, FuzzSeeds, ::testing::ValuesIn(test::fuzz_targets),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace simplexseg
