// SPDX-License-Identifier: Apache-2.0
// Answers of several parts (RFC 2046, 5.1) as they come, without ever holding a part.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace simplexseg {

/// The boundary that a Content-Type names, where that is multipart/related; else nothing.
std::optional<std::string> boundary_of(const std::string& content_type);

/// Takes an answer apart. Holds no more than what is fed and 64 KiB.
class MultipartReader {
 public:
  struct Part {
    std::function<void()> begin;
    std::function<void(const char* data, std::size_t bytes)> data;
    /// `whole`: the part is as long as its header says, where that says so.
    std::function<void(bool whole)> end;
  };
  MultipartReader(const std::string& boundary, Part part);

  /// False where the answer is no such one: headers without an end. What the functions throw comes through.
  bool feed(const char* data, std::size_t bytes);
  /// Whether the last part and what closes it have come.
  bool complete() const { return state_ == State::Over; }

 private:
  enum class State { Before, Delimiter, Headers, Body, Over };
  bool step();
  bool take_body();
  bool take_delimiter();
  void take_headers(const std::string& headers);

  const std::string delimiter_;  ///< "\r\n--boundary"
  Part part_;
  State state_ = State::Before;
  std::string pending_ = "\r\n";  ///< the first delimiter may stand at the very beginning
  bool damaged_ = false;
  bool in_part_ = false;
  std::uint64_t length_ = 0;
  std::optional<std::uint64_t> claimed_;
};

}  // namespace simplexseg
