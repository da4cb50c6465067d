// SPDX-License-Identifier: Apache-2.0
// Data and temporary folders of the io tests.
#pragma once
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "core/error.h"

namespace simplexseg::test {

/// Returns the folder of test data (SIMPLEXSEG_DATA, or next to the project). Tests that need it are skipped without
/// it.
inline std::filesystem::path data_folder() {
  const char* named = std::getenv("SIMPLEXSEG_DATA");
  return named ? std::filesystem::path(named) : std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "../shared/data";
}

inline const std::filesystem::path templates_folder = "/usr/share/mricron/templates";

#define REQUIRE_DATA(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << (path)

/// Fixture with a temporary folder for each test.
class FolderTest : public ::testing::Test {
 protected:
  FolderTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = std::filesystem::temp_directory_path() /
             (std::string("simplexseg-") + info->test_suite_name() + "-" + info->name() + "-" +
              std::to_string(::rand()) + "-" + std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    std::filesystem::create_directories(folder);
  }
  ~FolderTest() override {
    std::error_code error;
    std::filesystem::remove_all(folder, error);
  }
  std::filesystem::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  std::filesystem::path folder;
};

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Returns the message of the Error that f throws. The test fails for other exceptions, none, or a message of several
/// lines.
inline std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find_first_of("\n\r\t"), std::string::npos) << text;
    EXPECT_EQ(text.find("itk"), std::string::npos) << text;
    EXPECT_GT(text.size(), 20u) << text;
    return text;
  } catch (const std::exception& exception) {
    ADD_FAILURE() << "not an Error: " << exception.what();
    return {};
  }
  ADD_FAILURE() << "no Error";
  return {};
}

#define EXPECT_HAS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

}  // namespace simplexseg::test
