// SPDX-License-Identifier: Apache-2.0
#include "io/platform/header_text.h"

#include <cctype>
#include <sstream>

namespace simplexseg {

namespace {

constexpr std::uint64_t kMaxHeaderBytes = 1 << 24;

}  // namespace

HeaderLines::HeaderLines(const std::filesystem::path& path) : reader_(path, Compression::None), block_(1 << 14, '\0') {}

bool HeaderLines::get(char& c) {
  if (first_ == last_) first_ = 0, last_ = reader_.read(block_.data(), block_.size());
  if (first_ == last_ || read_ == kMaxHeaderBytes) return false;
  c = block_[first_++];
  ++read_;
  return true;
}

std::optional<std::string> HeaderLines::next() {
  std::string line;
  char c = '\0';
  while (get(c)) {
    if (c == '\n') {
      if (line.ends_with('\r')) line.pop_back();
      return line;
    }
    line += c;
  }
  if (line.empty() || read_ == kMaxHeaderBytes) return std::nullopt;
  return line;
}

std::string trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.remove_suffix(1);
  return std::string(text);
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::string digits_of(double value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

}  // namespace simplexseg
