// SPDX-License-Identifier: Apache-2.0
#include "remote/multipart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace simplexseg {
namespace {

struct ParsedParts {
  std::vector<std::string> parts;
  std::vector<bool> whole;
  bool fine = true, complete = false;
};

ParsedParts parse(const std::string& text, std::size_t block) {
  ParsedParts parsed;
  MultipartReader reader("frontier",
                         {[&] { parsed.parts.emplace_back(); },
                          [&](const char* data, std::size_t bytes) { parsed.parts.back().append(data, bytes); },
                          [&](bool whole) { parsed.whole.push_back(whole); }});
  for (std::size_t at = 0; at < text.size() && parsed.fine; at += block)
    parsed.fine = reader.feed(text.data() + at, std::min(block, text.size() - at));
  parsed.complete = reader.complete();
  return parsed;
}

TEST(Multipart, PartsDoNotDependOnTheBlockSize) {
  // A part may contain text that resembles a delimiter or its beginning.
  const std::vector<std::string> parts = {"first\r\n--front\r\n--frontierland\r\n", "", std::string("\0\r\n\r", 4),
                                          "--frontier\r\n--frontie"};
  std::string text = "a preamble\r\n--frontier \r\nContent-Type: application/dicom\r\ncontent-LENGTH:  " +
                     std::to_string(parts[0].size()) + "\r\n\r\n" + parts[0];
  text += "\r\n--frontier\r\n\r\n" + parts[1];                       // without headers
  text += "\r\n--frontier\r\nContent-Length: 5\r\n\r\n" + parts[2];  // one byte short
  text += "\r\n--frontier\r\nX: y\r\n\r\n" + parts[3] + "\r\n--frontier--\r\nan epilogue --frontier\r\n\r\n";
  for (std::size_t block = 1; block < text.size() + 1; ++block) {
    const ParsedParts parsed = parse(text, block);
    ASSERT_EQ(parsed.parts, parts) << "blocks of " << block;
    ASSERT_EQ(parsed.whole, (std::vector{true, true, false, true}));
    ASSERT_TRUE(parsed.fine && parsed.complete);
  }
}

TEST(Multipart, TruncatedResponsesAreIncomplete) {
  const std::string text = "--frontier\r\n\r\nabc\r\n--frontier--";
  EXPECT_TRUE(parse(text, 100).complete);
  for (std::size_t length = 0; length < text.size(); ++length) EXPECT_FALSE(parse(text.substr(0, length), 7).complete);
}

TEST(Multipart, UnterminatedHeadersAreRejected) {
  EXPECT_FALSE(parse("--frontier\r\n" + std::string(200000, 'x'), 1000).fine);
  EXPECT_FALSE(parse("--frontier" + std::string(200000, ' '), 1000).fine);
}

TEST(Multipart, BoundariesAreFoundAmongTheParameters) {
  EXPECT_EQ(boundary_of("multipart/related; boundary=abc"), "abc");
  EXPECT_EQ(boundary_of("Multipart/Related;type=\"application/dicom\";BOUNDARY=\"a b;c\"; x=y"), "a b;c");
  EXPECT_EQ(boundary_of("multipart/related; noboundary=x; boundary=abc; type=z"), "abc");
  EXPECT_FALSE(boundary_of("multipart/related"));
  EXPECT_FALSE(boundary_of("multipart/related; boundary="));
  EXPECT_FALSE(boundary_of("multipart/related; boundary=" + std::string(500, 'a')));
  EXPECT_FALSE(boundary_of("application/dicom; boundary=abc"));
}

}  // namespace
}  // namespace simplexseg
