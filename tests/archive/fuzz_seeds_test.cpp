// SPDX-License-Identifier: Apache-2.0
// Reads the fuzzer's seeds and findings, and randomly damaged seeds for compilers without a fuzzer.
#include "fuzz/archive_targets.h"
#include "fuzz/check_seeds.h"

namespace simplexseg {
namespace {

class ArchiveFuzzSeeds : public test::SeedsTest {};

TEST_P(ArchiveFuzzSeeds, SeedsAreReadAndFindingsReadOrRejected) { check_seeds(); }
TEST_P(ArchiveFuzzSeeds, DamagedSeedsGiveOneLineErrors) { check_damaged_seeds(); }

INSTANTIATE_TEST_SUITE_P(Readers, ArchiveFuzzSeeds, ::testing::ValuesIn(test::archive_fuzz_targets),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace simplexseg
