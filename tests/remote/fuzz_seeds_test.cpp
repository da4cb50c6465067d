// SPDX-License-Identifier: Apache-2.0
// Reads the fuzzer's seeds and findings, and randomly damaged seeds for compilers without a fuzzer.
#include "fuzz/check_seeds.h"
#include "fuzz/remote_targets.h"

namespace simplexseg {
namespace {

class RemoteFuzzSeeds : public test::SeedsTest {};

TEST_P(RemoteFuzzSeeds, SeedsAreReadAndFindingsReadOrRejected) { check_seeds(); }
TEST_P(RemoteFuzzSeeds, DamagedSeedsGiveOneLineErrors) { check_damaged_seeds(); }

INSTANTIATE_TEST_SUITE_P(Readers, RemoteFuzzSeeds, ::testing::ValuesIn(test::remote_fuzz_targets),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace simplexseg
