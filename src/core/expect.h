// SPDX-License-Identifier: Apache-2.0
// Debug assertions at the borders of rooms: what a caller promises, and what a function promises. They are for mistakes
// in the program, not for bad input, which is an Error (core/error.h) in every build.
#pragma once

#ifdef SIMPLEXSEG_ASSERTIONS  // the presets dev, asan and tsan
#include <cstdio>
#include <cstdlib>

namespace simplexseg::detail {
/// Ends the program: a broken promise leaves nothing to go on with, and a debugger or sanitizer shows where it was
/// broken.
[[noreturn]] inline void broken_promise(const char* kind, const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: %s(%s) does not hold\n", file, line, kind, condition);
  std::abort();
}
}  // namespace simplexseg::detail

#define SIMPLEXSEG_CHECK_PROMISE(kind, ...) \
  ((__VA_ARGS__) ? void() : ::simplexseg::detail::broken_promise(kind, #__VA_ARGS__, __FILE__, __LINE__))
#else
// Not evaluated, but compiled: a promise about what is no longer there does not compile.
#define SIMPLEXSEG_CHECK_PROMISE(kind, ...) ((void)sizeof(bool(__VA_ARGS__)))
#endif

/// What a function expects of its caller.
#define SIMPLEXSEG_EXPECT(...) SIMPLEXSEG_CHECK_PROMISE("EXPECT", __VA_ARGS__)
/// What a function ensures for its caller.
#define SIMPLEXSEG_ENSURE(...) SIMPLEXSEG_CHECK_PROMISE("ENSURE", __VA_ARGS__)
