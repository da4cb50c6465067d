// SPDX-License-Identifier: Apache-2.0
// Fuzz target: a reader of data from outside. Used by the fuzzer (fuzz.cpp) and by the tests that repeat its seeds and
// findings (check_seeds.h).
#pragma once
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/error.h"

namespace simplexseg::test {

struct FuzzTarget {
  const char* name;                                 ///< name of the target and of the folder with its seeds
  const char* file;                                 ///< file that receives the bytes; its extension selects the reader
  void (*read)(const std::filesystem::path& path);  ///< reads the file; may throw only Error
};

/// Bytes of a small file. read_bytes() has a large buffer, which the sanitizers clear at each call.
inline std::string small_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Fault of the target for this file: an exception other than Error, or a message that is not one line; empty: none.
inline std::string fault_of(const FuzzTarget& target, const std::filesystem::path& path) {
  try {
    target.read(path);
  } catch (const Error& error) {
    const std::string text = error.what();
    if (text.size() < 20 || text.find_first_of("\n\r\t") != std::string::npos) return "no line: " + text;
  } catch (const std::exception& exception) {
    return std::string("another exception than Error: ") + exception.what();
  }
  return {};
}

}  // namespace simplexseg::test
