// SPDX-License-Identifier: Apache-2.0
#include "remote/network_calls.h"

#include <algorithm>

#include "core/error.h"
#include "io/platform/files.h"
#include "remote/network_connection.h"
#include "remote/network_responses.h"

namespace simplexseg {
namespace {

constexpr int kMaxClaims = 3;  // leases for one mask

std::shared_ptr<const NetworkMask> mask_by(const NetworkServer& server, const NetworkConnection& connection,
                                           const NetworkInfo& info, const NetworkRequest& request) {
  auto result = std::make_shared<NetworkMask>();
  Mask mask = info.protocol == NetworkInfo::Protocol::NnInteractive ? nninteractive_mask(server, connection, request)
                                                                    : monai_label_mask(server, connection, request);
  result->voxels = object_at_prompts(std::move(mask), request.prompts);
  result->server = server.url;
  result->network = request.network;
  result->licence = info.licence;
  result->identity = identity_of(result->voxels);
  return result;
}

}  // namespace

HttpResponse NetworkConnection::send(const HttpRequest& request, const NetworkWaiting& waiting) const {
  HttpResponse response = http_.send(request, waiting);
  const std::string detail = response.status >= 400 ? detail_of(response.body) : "";
  const std::string number = " (" + std::to_string(response.status) + (detail.empty() ? "" : ": " + detail) + ")";
  switch (response.status) {
    case 400:
    case 406:
    case 422:
      throw remote_fault(server(), "it rejected the request" + number, "check image and prompts, or its version");
    case 404:
      throw remote_fault(server(), "it does not offer this" + number, "check its URL and its version");
    case 410:
      throw LeaseGone();
    case 413:
      throw remote_fault(server(), "the image is too large for it" + number, "use an image of a part of the body");
    case 500:
      throw remote_fault(server(), "it failed" + number, "look at its log");
    case 503:
      throw remote_fault(server(), "all its sessions are in use" + number, "try again later");
    default:
      http_.require_ok(response, "such request");
  }
  return response;
}

NetworkInfo network_info(const NetworkServer& server, const NetworkWaiting& waiting) {
  require_network_server(server);
  const NetworkConnection connection(server, waiting);
  try {
    if (const auto info = nninteractive_info(connection)) return *info;
    if (const auto info = monai_label_info(connection)) return *info;
  } catch (const LeaseGone&) {  // although none was claimed
    throw remote_fault(connection.server(), "it ended the session (410)", "check its version");
  }
  throw remote_fault(connection.server(), "it is neither a server of nnInteractive nor of MONAI Label",
                     "check its URL");
}

std::shared_ptr<const NetworkMask> segment_by_network(const NetworkServer& server, const NetworkRequest& request,
                                                      const NetworkWaiting& waiting) {
  if (request.volume.empty()) throw Error("a network", "there is no image", "open one first");
  const NetworkInfo info = network_info(server, waiting);
  NetworkRequest chosen = request;
  if (chosen.network.empty() && !info.networks.empty()) chosen.network = info.networks.front();
  const NetworkConnection connection(server, waiting);
  if (std::ranges::find(info.networks, chosen.network) == info.networks.end()) {
    std::string known;
    for (const std::string& name : info.networks) known += (known.empty() ? "" : ", ") + name;
    throw remote_fault(connection.server(), "it has no network " + one_line(chosen.network, 100),
                       known.empty() ? "load one there" : "choose one of: " + known);
  }
  for (int claim = 1; claim <= kMaxClaims; ++claim) {
    try {
      return mask_by(server, connection, info, chosen);
    } catch (const LeaseGone&) {  // claims another one and sends everything again
    }
  }
  throw remote_fault(connection.server(), "it ended the session three times (410)",
                     "ask its administrator for longer time limits");
}

}  // namespace simplexseg
