// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>

namespace simplexseg {

/// Exception thrown by all functions of the library for bad input or an unavailable resource. Its text is one line for
/// the user. The library itself never prints and never exits, except in debug assertions (core/expect.h).
class Error : public std::runtime_error {
 public:
  /// `what`: the problem, with the offending name or value; `why`: the cause; `what_to_do`: the remedy.
  Error(const std::string& what, const std::string& why, const std::string& what_to_do)
      : std::runtime_error(what + ": " + why + "; " + what_to_do) {}
  /// Error with the complete text of an earlier error.
  explicit Error(const std::string& line) : std::runtime_error(line) {}
};

/// Failure of the GPU (lost, or out of memory). The program can continue on the CPU.
class DeviceError : public Error {
 public:
  using Error::Error;
};

}  // namespace simplexseg
