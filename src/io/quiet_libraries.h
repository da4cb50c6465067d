// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>
#include <functional>
#include <string>

namespace simplexseg {

/// While one lives, nothing that GDCM or the libraries below it print reaches the program's output (they write to
/// stderr, so that is turned off). One thread at a time holds it, hence loads in several threads follow
/// each other; the same thread may nest it.
class QuietLibraries {
 public:
  QuietLibraries();
  ~QuietLibraries();
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;
};

/// Calls f while nobody holds that: what it prints to stderr is seen.
void while_heard(const std::function<void()>& f);

/// Calls f. Debian builds GDCM with its assertions, and a damaged file can break one, which would end the program; here
/// it is thrown as std::runtime_error instead (what GDCM held is leaked: its frames are left by siglongjmp). To be
/// called while a QuietLibraries is held, or in a child process, since abort() is one for all threads.
void without_aborting(const std::function<void()>& f);

/// What an exception of a library says, as one line without a full stop.
std::string plain_words(const std::exception& exception);

}  // namespace simplexseg
