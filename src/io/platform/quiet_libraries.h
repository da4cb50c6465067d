// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>
#include <functional>
#include <string>

namespace simplexseg {

/// Scope in which stderr is discarded, because GDCM and the libraries that it uses print there. Only one thread at a
/// time can be in such a scope, so loads in several threads run serially. Scopes of one thread can be nested.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;
};

/// Calls f while no other thread is in a scope of QuietLibraries, so that output to stderr is visible. If the calling
/// thread is in such a scope, stderr remains discarded.
void with_stderr_enabled(const std::function<void()>& f);

/// Calls f and converts abort() into std::runtime_error. Debian builds GDCM with assertions, and a damaged file can
/// make an assertion fail. The function then leaves GDCM's stack frames by siglongjmp(), which leaks their memory. Call
/// it only in a scope of QuietLibraries or in a worker process, since all threads share the signal handler.
void without_aborting(const std::function<void()>& f);

/// Returns the message of an exception on one line, without a period at its end.
std::string message_of(const std::exception& exception);

}  // namespace simplexseg
