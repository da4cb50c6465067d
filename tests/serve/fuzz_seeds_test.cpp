// SPDX-License-Identifier: Apache-2.0
// Reads the fuzzer's seeds and findings, and randomly damaged seeds for compilers without a fuzzer.
#include "fuzz/check_seeds.h"
#include "fuzz/serve_targets.h"

namespace simplexseg {
namespace {

class ServeFuzzSeeds : public test::SeedsTest {};

TEST_P(ServeFuzzSeeds, SeedsAreReadAndFindingsReadOrRejected) { check_seeds(); }
TEST_P(ServeFuzzSeeds, DamagedSeedsGiveOneLineErrors) { check_damaged_seeds(); }

INSTANTIATE_TEST_SUITE_P(Readers, ServeFuzzSeeds, ::testing::ValuesIn(test::serve_fuzz_targets),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace simplexseg
