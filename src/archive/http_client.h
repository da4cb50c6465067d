// SPDX-License-Identifier: Apache-2.0
// HTTP requests through libcurl. Only the source file includes headers of libcurl.
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

/// Body of a request, read in blocks; `length` in bytes.
struct HttpBody {
  std::string content_type;
  std::uint64_t length = 0;
  std::function<std::size_t(char* to, std::size_t capacity)> read;  ///< returns the number of bytes written to `to`
};

/// Receiver of the body of a response with status 200, called for each block of it.
using HttpSink = std::function<void(const std::string& content_type, const char* data, std::size_t bytes)>;

/// HTTP client for one server, which must outlive it. Verifies certificates. Does not follow redirections, which could
/// send the credentials to another server. Requests throw ArchiveFault when they fail before the response is complete;
/// the caller checks the status (require_ok()).
class HttpClient {
 public:
  /// Reads the credentials. Throws the errors of read_credentials().
  explicit HttpClient(const ArchiveServer& server);

  /// Sends a request. `path`: text appended to the server's URL ("/studies?...", values escaped); `accept`: accepted
  /// media type; `waiting`: called at least once a second, its exceptions are passed on.
  HttpResponse get(const std::string& path, const std::string& accept, const std::function<void()>& waiting) const;
  HttpResponse get(const std::string& path, const std::string& accept, const HttpSink& sink,
                   const std::function<void()>& waiting) const;
  HttpResponse post(const std::string& path, const std::string& accept, const HttpBody& body,
                    const std::function<void()>& waiting) const;

  /// Throws ArchiveFault for a status outside 200 to 299. `what`: object that is missing if the status is 404, for the
  /// message.
  void require_ok(const HttpResponse& response, const std::string& what) const;

 private:
  struct Transfer;
  HttpResponse perform(const std::string& path, const std::string& accept, Transfer& transfer) const;
  ArchiveFault fault_of(int curl_code, const char* error_text, const Transfer& transfer) const;

  const ArchiveServer& server_;
  Credentials credentials_;
};

/// Escapes a value of a query for a URL (RFC 3986); '*' stays as a wildcard.
std::string url_escaped(const std::string& text);

}  // namespace simplexseg
