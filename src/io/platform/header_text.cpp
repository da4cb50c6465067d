// SPDX-License-Identifier: Apache-2.0
#include "io/platform/header_text.h"

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
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return std::string(text);
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  bool in_word = false;
  for (const char c : text) {
    if (!is_space(c) && !in_word) words.emplace_back();
    in_word = !is_space(c);
    if (in_word) words.back() += c;
  }
  return words;
}

std::string digits_of(double value) { return exact_text(value); }

}  // namespace simplexseg
