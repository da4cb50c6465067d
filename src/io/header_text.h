// SPDX-License-Identifier: Apache-2.0
// Headers of lines of text, as NRRD and MetaImage have them.
#pragma once
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "io/packed_reader.h"

namespace simplexseg {

/// The lines at the start of a file, of 16 MB at most.
class HeaderLines {
 public:
  /// Throws Error when the file is missing, empty or cannot be opened.
  explicit HeaderLines(const std::filesystem::path& path);
  /// The next line without its end; nothing at the end of the file, or where the lines grow longer than any header's.
  std::optional<std::string> next();
  /// Bytes of the file up to the end of the last line.
  std::uint64_t read() const { return read_; }

 private:
  bool get(char& c);

  PackedReader reader_;
  std::string block_;
  std::size_t first_ = 0, last_ = 0;
  std::uint64_t read_ = 0;
};

/// Without blanks at both ends.
std::string trimmed(std::string_view text);
/// Small letters, for ASCII.
std::string lower_case(std::string_view text);
/// The parts between blanks.
std::vector<std::string> words_of(const std::string& text);

/// The number that is all of `text`, in the "C" locale; nothing where it is none, or out of range.
template <class T>
std::optional<T> number_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  T value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The fewest digits that give the same number back.
std::string digits_of(double value);

}  // namespace simplexseg
