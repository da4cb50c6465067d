// SPDX-License-Identifier: Apache-2.0
// Contents of the responses of segmentation servers, independent of the connection. All functions throw RemoteFault
// with one line for a response that is damaged.
#pragma once
#include <optional>
#include <string>

#include "remote/http_client.h"
#include "remote/network_calls.h"

namespace simplexseg {

/// One line of a text that a server sent: its first 200 bytes, and " ..." if it is longer.
std::string stated(const std::string& text);
/// Text "detail" of the body of an error, as stated(); "" without one.
std::string detail_of(const std::string& body);

/// Lease of a session of nnInteractive.
struct NetworkLease {
  std::string token;   ///< 1 to 200 printable characters of ASCII
  double beat_s = 20;  ///< longest time between two heartbeats, 0.5 to 600 s
};
/// Lease in the response to a claim.
NetworkLease lease_of(const WebServer& server, const std::string& body);
/// Statements of a server of nnInteractive, from its capabilities.
NetworkInfo info_of_capabilities(const WebServer& server, const std::string& body);
/// Writes the region of a response of nnInteractive into a mask: header X-Meta with the ranges of the region along
/// k, j, i, and an array of one byte for each of its voxels.
void take_region(const WebServer& server, const HttpResponse& response, Mask& mask);

/// Statements of a server of MONAI Label; nullopt for a response of another kind.
std::optional<NetworkInfo> info_of_models(const std::string& body);
/// Identifier in the response to a new session of MONAI Label.
std::string session_of(const WebServer& server, const std::string& body);

}  // namespace simplexseg
