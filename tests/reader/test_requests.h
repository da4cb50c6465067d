// SPDX-License-Identifier: Apache-2.0
// Requests of the test program simplexseg-test-reader.
#pragma once
#include <cstdint>
#include <string>

#include "io/platform/worker_request.h"

namespace simplexseg::test {

inline constexpr RequestType<std::string, std::string> kEcho{"echo"};
/// Fails in the named manner; see test_reader.cpp.
inline constexpr RequestType<std::string, std::string> kFail{"fail"};
inline constexpr RequestType<bool, std::uint64_t> kAllocate{"allocate"};
/// Creates a file in TMPDIR and returns its path.
inline constexpr RequestType<std::string> kLeaveFile{"leave file"};
/// Sends a number of bytes, and then fails in the named manner.
inline constexpr RequestType<void, std::uint64_t, std::string> kSend{"send"};

}  // namespace simplexseg::test
