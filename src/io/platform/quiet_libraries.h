// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>
#include <functional>
#include <string>

namespace simplexseg {

/// Scope in which stderr is discarded, because GDCM and the libraries that it uses print there. Only one thread at a
/// time can hold it, so loads in several threads run one after the other. One thread may nest it.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;
};

/// Calls f while no thread holds a QuietLibraries, so output to stderr is visible.
void with_stderr_enabled(const std::function<void()>& f);

/// Calls f and converts abort() into std::runtime_error. Debian builds GDCM with assertions, and a damaged file can
/// make one fail; siglongjmp() then leaves GDCM's stack frames, and their memory is leaked. Call it only while a
/// QuietLibraries is held or in a worker process, since the signal handler is shared by all threads.
void without_aborting(const std::function<void()>& f);

/// Returns the message of an exception as one line without a full stop.
std::string message_of(const std::exception& exception);

}  // namespace simplexseg
