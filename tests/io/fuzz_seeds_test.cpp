// SPDX-License-Identifier: Apache-2.0
// Reads the fuzzer's seeds and findings, and several thousand randomly damaged seeds for compilers without a fuzzer.
#include <algorithm>
#include <random>

#include "../fuzz/targets.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::fault_of;
using test::FuzzTarget;

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

class FuzzSeeds : public test::FolderTest, public ::testing::WithParamInterface<FuzzTarget> {
 protected:
  const fs::path seeds = fs::path(SIMPLEXSEG_SOURCE_DIR) / "tests/fuzz/seeds" / GetParam().name;
};

/// Seeds are valid files; names starting with "found-" are files that once caused a failure.
TEST_P(FuzzSeeds, SeedsAreReadAndFindingsReadOrRejected) {
  int valid = 0;
  for (const fs::path& file : files_of(seeds)) {
    SCOPED_TRACE(file);
    const fs::path copy = write(GetParam().file, bytes_of(file));
    EXPECT_EQ(fault_of(GetParam(), copy), "");
    if (file.filename().string().starts_with("found-")) continue;
    ++valid;
    EXPECT_NO_THROW(GetParam().read(copy));
  }
  EXPECT_GE(valid, 1);
}

TEST_P(FuzzSeeds, DamagedSeedsGiveOneLineErrors) {
  // SIMPLEXSEG_FUZZ_ROUNDS sets the number of rounds, e.g. for sanitizers; it also changes the random seed.
  const char* const text = std::getenv("SIMPLEXSEG_FUZZ_ROUNDS");
  const int rounds = text ? std::atoi(text) : 40;
  std::mt19937 random(static_cast<unsigned>(rounds));
  for (const fs::path& file : files_of(seeds)) {
    const std::string whole = bytes_of(file);
    for (int round = 0; round < rounds; ++round) {
      std::string bytes = whole;
      for (unsigned change = 0; change < 1 + random() % 4 && !bytes.empty(); ++change) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 4) {
          case 0:
            bytes[at] = static_cast<char>(random());
            break;
          case 1:
            bytes[at] = "\0\xff\x7f\x80 -9"[random() % 7];
            break;
          case 2:
            bytes.erase(at, 1 + random() % 8);
            break;
          default:
            bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 16));
        }
      }
      const fs::path path = write(GetParam().file, bytes);
      const std::string fault = fault_of(GetParam(), path);
      EXPECT_EQ(fault, "") << file << ", round " << round;
      if (fault.empty()) continue;
      fs::copy_file(path, fs::temp_directory_path() / ("found-" + std::string(GetParam().name)),
                    fs::copy_options::overwrite_existing);
      break;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Readers, FuzzSeeds, ::testing::ValuesIn(test::fuzz_targets),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace simplexseg
