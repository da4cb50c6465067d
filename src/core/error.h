// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>

namespace simplexseg {

/// What every function of the library throws on bad input or a failed resource: one line for the user.
/// The library itself never prints and never exits.
class Error : public std::runtime_error {
 public:
  /// `what`: the problem with the offending name or value; `why`: the cause; `what_to_do`: the remedy.
  Error(const std::string& what, const std::string& why, const std::string& what_to_do)
      : std::runtime_error(what + ": " + why + "; " + what_to_do) {}
  /// An error that was one already.
  explicit Error(const std::string& line) : std::runtime_error(line) {}
};

/// The device failed (it was lost, or has not the memory): the program can go on without it.
class DeviceError : public Error {
 public:
  using Error::Error;
};

}  // namespace simplexseg
