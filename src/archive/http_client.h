// SPDX-License-Identifier: Apache-2.0
// Requests over HTTP by libcurl, which is known in the source alone.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "archive/archive.h"
#include "archive/credentials.h"

namespace simplexseg {

struct HttpAnswer {
  int status = 0;
  std::string content_type;
  std::string body;
};

/// What is sent, block by block.
struct HttpBody {
  std::string content_type;
  std::uint64_t length = 0;
  std::function<std::size_t(char* to, std::size_t most)> read;  ///< gives the bytes written to `to`
};

/// Where the body of an answer of status 200 goes as it comes. `content_type` is that of the answer.
using HttpSink = std::function<void(const std::string& content_type, const char* data, std::size_t bytes)>;

/// Certificates are verified; redirections are not followed, since they would take the credentials elsewhere. Throws
/// Error for whatever ends before there is a whole answer; statuses are the caller's to judge (require_ok()).
class HttpClient {
 public:
  /// Reads the credentials. Throws Error as read_credentials().
  explicit HttpClient(const ArchiveServer& server);

  /// `path`: behind the server's URL, "/studies?..." with each value escaped. `waiting` is called at least once a
  /// second; what it throws comes through.
  HttpAnswer get(const std::string& path, const std::string& accept, const std::function<void()>& waiting) const;
  HttpAnswer get(const std::string& path, const std::string& accept, const HttpSink& sink,
                 const std::function<void()>& waiting) const;
  HttpAnswer post(const std::string& path, const std::string& accept, const HttpBody& body,
                  const std::function<void()>& waiting) const;

  /// Throws Error for a status that is not 200 to 299. `what`: what is missing where it is 404.
  void require_ok(const HttpAnswer& answer, const std::string& what) const;

 private:
  struct Transfer;
  HttpAnswer perform(const std::string& path, const std::string& accept, Transfer& transfer) const;
  ArchiveFault fault_of(int curl_code, const char* words, const Transfer& transfer) const;

  const ArchiveServer& server_;
  Credentials credentials_;
};

/// A value as it stands in a URL.
std::string url_escaped(const std::string& text);

}  // namespace simplexseg
