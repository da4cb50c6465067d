// SPDX-License-Identifier: Apache-2.0
// Requests to a segmentation server, for the sources of both protocols.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "remote/http_client.h"
#include "remote/network_calls.h"

namespace simplexseg {

/// Thrown when a server no longer knows a lease (status 410).
struct LeaseGone {};

/// Connection to a segmentation server. Each request throws LeaseGone, or RemoteFault with one line for any other
/// status outside 200 to 299.
class NetworkConnection {
 public:
  NetworkConnection(const NetworkServer& server, const NetworkWaiting& waiting)
      : http_(web_server_of(server)), waiting_(waiting) {}

  const WebServer& server() const { return http_.server(); }
  HttpResponse send(const HttpRequest& request) const { return send(request, waiting_); }
  HttpResponse send(const HttpRequest& request, const NetworkWaiting& waiting) const;
  /// Response to a request whose status may be any.
  HttpResponse probe(const HttpRequest& request) const { return http_.send(request, waiting_); }
  void wait() const { waiting_(); }

 private:
  const HttpClient http_;
  const NetworkWaiting& waiting_;
};

/// Statements of a server of nnInteractive about itself; nullopt if it is none.
std::optional<NetworkInfo> nninteractive_info(const NetworkConnection& connection);
/// Statements of a server of MONAI Label about itself; nullopt if it is none.
std::optional<NetworkInfo> monai_label_info(const NetworkConnection& connection);

/// Mask of an image and prompts. `server`: for requests with a shorter time-out.
Mask nninteractive_mask(const NetworkServer& server, const NetworkConnection& connection,
                        const NetworkRequest& request);
Mask monai_label_mask(const NetworkServer& server, const NetworkConnection& connection, const NetworkRequest& request);

}  // namespace simplexseg
