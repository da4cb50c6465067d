// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

namespace simplexseg {

class SegmentationService;

/// Transport of a SegmentationService: HTTP 1.1 without encryption, one request for each connection. Requests of
/// browsers (header Origin), compressed and chunked bodies are refused. Bodies above 1 MiB are received one at a time.
class HttpServer {
 public:
  /// Listens. `address`: IP address; `port`: 0 for an unused one. `service` must outlive the server. Throws Error if
  /// built without libcpp-httplib, for an address that is none, and for one that is in use or not permitted.
  HttpServer(SegmentationService& service, const std::string& address, int port);
  /// Stops and waits for all requests.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  /// Accepts no more requests, and makes running ones end soon; from any thread.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Whether an IP address is one of the loopback. Throws Error for an address that is none.
bool is_loopback(const std::string& address);

}  // namespace simplexseg
