// SPDX-License-Identifier: Apache-2.0
// Line-based text headers, as in NRRD and MetaImage files.
#pragma once
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/number_text.h"
#include "io/platform/decompressing_reader.h"

namespace simplexseg {

/// Reader of the text lines at the start of a file, at most 16 MiB.
class HeaderLines {
 public:
  /// Opens the file. Throws Error when it is missing, empty or cannot be opened.
  explicit HeaderLines(const std::filesystem::path& path);
  /// Returns the next line without its line break; nullopt at the end of the file or after 16 MiB.
  std::optional<std::string> next();
  /// Returns the number of bytes up to the end of the last returned line, including its line break.
  std::uint64_t bytes_read() const { return read_; }

 private:
  bool get(char& c);

  DecompressingReader reader_;
  std::string block_;
  std::size_t first_ = 0, last_ = 0;
  std::uint64_t read_ = 0;
};

/// Returns the text without leading and trailing white space.
std::string trimmed(std::string_view text);
/// Returns the words of the text, which are separated by white space.
std::vector<std::string> words_of(const std::string& text);

/// Parses the whole text as one number in the "C" locale; a leading "+" is allowed. Returns nullopt when the text is
/// not a number or the number is out of range.
template <class T>
std::optional<T> number_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  T value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Returns the shortest decimal text that parses to exactly `value`.
std::string digits_of(double value);

}  // namespace simplexseg
