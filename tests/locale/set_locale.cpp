// SPDX-License-Identifier: Apache-2.0
// Selects the locale of the environment before the tests run, as Qt does in the window, where SIMPLEXSEG_TEST_LOCALE is
// set (tests/locale/run). Part of every test program.
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

[[maybe_unused]] const bool is_set = [] {
  if (!std::getenv("SIMPLEXSEG_TEST_LOCALE")) return false;
  char text[16] = "";
  if (std::setlocale(LC_ALL, "")) std::snprintf(text, sizeof text, "%.1f", 1.5);
  if (std::strcmp(text, "1,5") == 0) return true;
  std::fputs("the locale of the environment does not exist or has no decimal comma\n", stderr);
  std::_Exit(1);
}();

}  // namespace
