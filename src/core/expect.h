// SPDX-License-Identifier: Apache-2.0
// Debug assertions for pre- and postconditions of functions that other modules call. They catch mistakes in the
// program. Bad input throws an Error (core/error.h) in every build.
#pragma once

#ifdef SIMPLEXSEG_ASSERTIONS  // the presets dev, asan and tsan
#include <cstdio>
#include <cstdlib>

namespace simplexseg::detail {
/// Aborts the program, so that a debugger or sanitizer stops at the violated condition.
[[noreturn]] inline void contract_violated(const char* kind, const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: %s(%s) does not hold\n", file, line, kind, condition);
  std::abort();
}
}  // namespace simplexseg::detail

#define SIMPLEXSEG_CHECK_CONTRACT(kind, ...) \
  ((__VA_ARGS__) ? void() : ::simplexseg::detail::contract_violated(kind, #__VA_ARGS__, __FILE__, __LINE__))
#else
// Compiled but not evaluated, so that a condition with outdated names is a compile error.
#define SIMPLEXSEG_CHECK_CONTRACT(kind, ...) ((void)sizeof(bool(__VA_ARGS__)))
#endif

/// Checks a precondition, which the caller must ensure.
#define SIMPLEXSEG_EXPECT(...) SIMPLEXSEG_CHECK_CONTRACT("EXPECT", __VA_ARGS__)
/// Checks a postcondition, which the function must ensure.
#define SIMPLEXSEG_ENSURE(...) SIMPLEXSEG_CHECK_CONTRACT("ENSURE", __VA_ARGS__)
