// SPDX-License-Identifier: Apache-2.0
// HTTP requests through libcurl, which only the source file includes.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "archive/archive.h"
#include "archive/credentials.h"

namespace simplexseg {

/// Response to a request.
struct HttpResponse {
  int status = 0;
  std::string content_type;
  std::string body;
};

/// Body of a request, read block by block.
struct HttpBody {
  std::string content_type;
  std::uint64_t length = 0;
  std::function<std::size_t(char* to, std::size_t capacity)> read;  ///< returns the number of bytes written to `to`
};

/// Receiver of the body of a response with status 200, block by block. `content_type`: content type of the response.
using HttpSink = std::function<void(const std::string& content_type, const char* data, std::size_t bytes)>;

/// HTTP client of one server. It verifies certificates and does not follow redirections, which could send the
/// credentials to another server. Requests throw ArchiveFault when they fail before the response is complete; the
/// caller checks the status (require_ok()).
class HttpClient {
 public:
  /// Reads the credentials; throws Error like read_credentials().
  explicit HttpClient(const ArchiveServer& server);

  /// Requests a path, which is appended to the server's URL ("/studies?...", values escaped). `waiting` is called at
  /// least once a second; its exceptions are passed on.
  HttpResponse get(const std::string& path, const std::string& accept, const std::function<void()>& waiting) const;
  HttpResponse get(const std::string& path, const std::string& accept, const HttpSink& sink,
                   const std::function<void()>& waiting) const;
  HttpResponse post(const std::string& path, const std::string& accept, const HttpBody& body,
                    const std::function<void()>& waiting) const;

  /// Throws ArchiveFault for a status outside 200 to 299. `what`: name of the missing object, for 404.
  void require_ok(const HttpResponse& response, const std::string& what) const;

 private:
  struct Transfer;
  HttpResponse perform(const std::string& path, const std::string& accept, Transfer& transfer) const;
  ArchiveFault fault_of(int curl_code, const char* error_text, const Transfer& transfer) const;

  const ArchiveServer& server_;
  Credentials credentials_;
};

/// Escapes a value for a URL.
std::string url_escaped(const std::string& text);

}  // namespace simplexseg
