// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <iosfwd>
#include <stdexcept>

namespace simplexseg {

/// Output streams of a command-line subcommand.
struct Console {
  std::ostream& out;
  std::ostream& err;
  bool shows_progress;  ///< true if `err` is a terminal
};

/// Failure of a valid request, which ends the program with exit status 1. Invalid input throws Error: exit status 2.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace simplexseg
