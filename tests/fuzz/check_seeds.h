// SPDX-License-Identifier: Apache-2.0
// Checks of fuzz targets without a fuzzer: its seeds and findings, and several thousand randomly damaged seeds.
#pragma once
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "fuzz/target.h"
#include "io/test_files.h"

namespace simplexseg::test {

/// Seeds of a target, sorted.
inline std::vector<std::filesystem::path> seeds_of(const FuzzTarget& target) {
  const auto folder = std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "tests/fuzz/seeds" / target.name;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Test fixture of the targets of a module.
class SeedsTest : public FolderTest, public ::testing::WithParamInterface<FuzzTarget> {
 protected:
  /// Seeds are valid data; names starting with "found-" are data that once caused a failure.
  void check_seeds() {
    int valid = 0;
    for (const std::filesystem::path& file : seeds_of(GetParam())) {
      SCOPED_TRACE(file);
      const std::filesystem::path copy = write(GetParam().file, bytes_of(file));
      EXPECT_EQ(fault_of(GetParam(), copy), "");
      if (file.filename().string().starts_with("found-")) continue;
      ++valid;
      EXPECT_NO_THROW(GetParam().read(copy));
    }
    EXPECT_GE(valid, 1);
  }

  void check_damaged_seeds() {
    // SIMPLEXSEG_FUZZ_ROUNDS sets the number of rounds, e.g. for sanitizers; it also changes the random seed.
    const char* const text = std::getenv("SIMPLEXSEG_FUZZ_ROUNDS");
    const int rounds = text ? std::atoi(text) : 40;
    std::mt19937 random(static_cast<unsigned>(rounds));
    for (const std::filesystem::path& file : seeds_of(GetParam())) {
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
        const std::filesystem::path path = write(GetParam().file, bytes);
        const std::string fault = fault_of(GetParam(), path);
        EXPECT_EQ(fault, "") << file << ", round " << round;
        if (fault.empty()) continue;
        std::filesystem::copy_file(path,
                                   std::filesystem::temp_directory_path() / ("found-" + std::string(GetParam().name)),
                                   std::filesystem::copy_options::overwrite_existing);
        break;
      }
    }
  }
};

}  // namespace simplexseg::test
