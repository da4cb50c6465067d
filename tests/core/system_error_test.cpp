// SPDX-License-Identifier: Apache-2.0
#include "core/system_error.h"

#include <gtest/gtest.h>

#include <cerrno>

namespace simplexseg {
namespace {

TEST(SystemErrorText, IsEnglishUnderEveryLocale) {
  EXPECT_EQ(system_error_text(EACCES), "Permission denied");
  EXPECT_EQ(system_error_text(std::make_error_code(std::errc::no_such_file_or_directory)), "No such file or directory");
  EXPECT_EQ(system_error_text(99999), "error 99999 of the operating system");
}

}  // namespace
}  // namespace simplexseg
