// SPDX-License-Identifier: Apache-2.0
// HTTP requests through libcurl. Only the source file includes headers of libcurl.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "remote/credentials.h"
#include "remote/web_server.h"

namespace simplexseg {

/// Response to a request.
struct HttpResponse {
  int status = 0;
  std::string content_type;
  std::string meta;  ///< header X-Meta
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

/// Request other than those of HttpClient::get() and post().
struct HttpRequest {
  std::string method;  ///< "GET", "POST", "PUT" or "DELETE"
  std::string path;    ///< text appended to the server's URL ("/studies?...", values escaped)
  std::string accept;  ///< accepted media type
  std::vector<std::pair<std::string, std::string>> headers;  ///< further headers: name and value
  std::string content_type, content;                         ///< body of POST and PUT
  std::uint64_t max_bytes = 32'000'000;                      ///< largest response that is stored in memory
};

/// HTTP client for one server. Verifies certificates. Does not follow redirections, which could send the credentials to
/// another server. Requests throw RemoteFault when they fail before the response is complete; the caller checks the
/// status (require_ok()).
class HttpClient {
 public:
  /// Reads the credentials. Throws the errors of read_credentials().
  explicit HttpClient(const WebServer& server);

  /// Sends a request. `path`: text appended to the server's URL ("/studies?...", values escaped); `accept`: accepted
  /// media type; `waiting`: called at least once a second, its exceptions are passed on.
  HttpResponse get(const std::string& path, const std::string& accept, const std::function<void()>& waiting) const;
  HttpResponse get(const std::string& path, const std::string& accept, const HttpSink& sink,
                   const std::function<void()>& waiting) const;
  HttpResponse post(const std::string& path, const std::string& accept, const HttpBody& body,
                    const std::function<void()>& waiting) const;

  HttpResponse send(const HttpRequest& request, const std::function<void()>& waiting) const;

  const WebServer& server() const { return server_; }
  /// Throws RemoteFault for a status outside 200 to 299. `what`: object that is missing if the status is 404, for the
  /// message.
  void require_ok(const HttpResponse& response, const std::string& what) const;

 private:
  struct Transfer;
  HttpResponse perform(const HttpRequest& request, Transfer& transfer) const;
  RemoteFault fault_of(int curl_code, const char* error_text, const Transfer& transfer) const;

  const WebServer server_;
  Credentials credentials_;
};

/// Escapes a value of a query for a URL (RFC 3986); '*' stays as a wildcard.
std::string url_escaped(const std::string& text);

}  // namespace simplexseg
