// SPDX-License-Identifier: Apache-2.0
// Streaming parser for multipart responses (RFC 2046, 5.1).
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace simplexseg {

/// Boundary in a Content-Type of multipart/related; nullopt for other types and for a missing or too long boundary.
std::optional<std::string> boundary_of(const std::string& content_type);

/// Splits a response into its parts. Buffers at most the last block and about 64 KiB before it.
class MultipartReader {
 public:
  struct Part {
    std::function<void()> begin;
    std::function<void(const char* data, std::size_t bytes)> data;
    /// `complete`: the length of the part matches its Content-Length; also true for a part without one.
    std::function<void(bool complete)> end;
  };
  MultipartReader(const std::string& boundary, Part part);

  /// Parses the next block. Returns false if the headers of a part do not end within 64 KiB. Exceptions of the
  /// callbacks are passed on.
  bool feed(const char* data, std::size_t bytes);
  /// Whether the closing delimiter has been read.
  bool complete() const { return state_ == State::End; }

 private:
  enum class State { Before, Delimiter, Headers, Body, End };
  bool step();
  bool parse_body();
  bool parse_delimiter();
  void parse_headers(const std::string& headers);

  const std::string delimiter_;  ///< "\r\n--boundary"
  Part part_;
  State state_ = State::Before;
  std::string pending_ = "\r\n";  ///< data to parse; a first delimiter may lack its line break
  bool damaged_ = false;
  bool in_part_ = false;
  std::uint64_t length_ = 0;
  std::optional<std::uint64_t> content_length_;
};

}  // namespace simplexseg
