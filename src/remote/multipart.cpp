// SPDX-License-Identifier: Apache-2.0
#include "remote/multipart.h"

#include <algorithm>

#include "core/number_text.h"
#include "io/platform/header_text.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMaxHeader = std::size_t{1} << 16;
constexpr std::size_t kMaxBoundary = 200;  // RFC 2046 allows 70

}  // namespace

std::optional<std::string> boundary_of(const std::string& content_type) {
  const std::string lower = lower_ascii(content_type);
  if (!lower.starts_with("multipart/related")) return {};
  const std::string key = "boundary=";
  std::size_t at = 0;
  do {
    at = lower.find(key, at + 1);
  } while (at != std::string::npos && lower[at - 1] != ';' && lower[at - 1] != ' ' && lower[at - 1] != '\t');
  if (at == std::string::npos) return {};
  std::string boundary = content_type.substr(at + key.size());
  if (boundary.starts_with('"'))
    boundary = boundary.substr(1, boundary.find('"', 1) - 1);
  else
    boundary = boundary.substr(0, boundary.find_first_of("; \t"));
  if (boundary.empty() || boundary.size() > kMaxBoundary) return {};
  return boundary;
}

MultipartReader::MultipartReader(const std::string& boundary, Part part)
    : delimiter_("\r\n--" + boundary), part_(std::move(part)) {}

bool MultipartReader::feed(const char* data, std::size_t bytes) {
  if (state_ == State::End) return true;  // data after the closing delimiter is ignored
  pending_.append(data, bytes);
  while (!damaged_ && step()) {
  }
  return !damaged_;
}

/// Parses up to the next change of the state. Returns false when more data is needed or the response has ended.
bool MultipartReader::step() {
  switch (state_) {
    case State::Before:
    case State::Body:
      return parse_body();
    case State::Delimiter:
      return parse_delimiter();
    case State::Headers: {
      const std::size_t end = pending_.find("\r\n\r\n");
      if (end == std::string::npos) {
        damaged_ = pending_.size() > kMaxHeader;
        return false;
      }
      parse_headers(pending_.substr(0, end + 2));
      pending_.erase(0, end + 4);
      state_ = State::Body;
      return true;
    }
    case State::End:
      break;
  }
  return false;
}

/// Passes on all data up to the next delimiter, except bytes at the end that may be the beginning of one.
bool MultipartReader::parse_body() {
  const std::size_t found = pending_.find(delimiter_);
  const std::size_t available = pending_.size() - std::min(pending_.size(), delimiter_.size() - 1);
  const std::size_t count = std::min(found, available);
  if (state_ == State::Body && count > 0) {
    length_ += count;
    part_.data(pending_.data(), count);
  }
  pending_.erase(0, count);
  if (found == std::string::npos) return false;
  state_ = State::Delimiter;
  return true;
}

/// Parses a possible delimiter at the start of `pending_`. The characters after it decide whether it is a delimiter.
bool MultipartReader::parse_delimiter() {
  std::size_t at = delimiter_.size();
  while (at < pending_.size() && (pending_[at] == ' ' || pending_[at] == '\t')) ++at;
  if (at > delimiter_.size() + kMaxHeader) damaged_ = true;
  if (pending_.size() < at + 2) return false;
  const bool last = pending_.compare(at, 2, "--") == 0;
  if (!last && pending_.compare(at, 2, "\r\n") != 0) {  // not a delimiter
    if (in_part_) {
      length_ += delimiter_.size();
      part_.data(pending_.data(), delimiter_.size());
    }
    pending_.erase(0, delimiter_.size());
    state_ = in_part_ ? State::Body : State::Before;
    return true;
  }
  if (in_part_) part_.end(!content_length_ || *content_length_ == length_);
  in_part_ = false;
  if (last) {
    pending_.clear();
    state_ = State::End;
    return false;
  }
  pending_.erase(0, at);  // this line break is also the end of empty headers
  state_ = State::Headers;
  return true;
}

void MultipartReader::parse_headers(const std::string& headers) {
  content_length_.reset();
  length_ = 0;
  const std::string lower = lower_ascii(headers), key = "\r\ncontent-length:";
  if (const std::size_t at = lower.find(key); at != std::string::npos) {
    const std::size_t begin = at + key.size(), end = std::min(lower.find("\r\n", begin), lower.size());
    const auto length = parse_integer(std::string_view(lower).substr(begin, end - begin));
    if (length && *length >= 0) content_length_ = static_cast<std::uint64_t>(*length);
  }
  in_part_ = true;
  part_.begin();
}

}  // namespace simplexseg
