// SPDX-License-Identifier: Apache-2.0
// Calls of a segmentation server that the user runs: the inference server of nnInteractive, or MONAI Label
// (docs/networks.md). The first requests determine which of the two it is.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "image/volume.h"
#include "remote/network_prompts.h"
#include "remote/network_server.h"

namespace simplexseg {

/// Statements of a server about itself. Texts are one line of at most 200 bytes and " ...".
struct NetworkInfo {
  enum class Protocol { NnInteractive, MonaiLabel };
  Protocol protocol = Protocol::NnInteractive;
  std::vector<std::string> networks;  ///< names of the networks to choose from; the first is the default
  std::string licence;                ///< of the weights; empty: not stated
  std::vector<std::string> inputs;    ///< kinds of prompts; empty: not stated
  int scribble_voxels = 0;            ///< thickness of scribbles that it prefers; 0: it accepts none
};

/// Name of a protocol for messages: "nnInteractive" or "MONAI Label".
const char* name_of(NetworkInfo::Protocol protocol);

/// Default expected error of the surface of a mask (MeshStart::error_mm), mm.
inline constexpr double kNetworkErrorMm = 2;
/// Smallest expected error that can be chosen, mm.
inline constexpr double kMinNetworkErrorMm = 0.1;

/// Called at least once a second during a call. An exception (Cancelled) ends the call.
using NetworkWaiting = std::function<void()>;

/// Image and prompts for a network. Sent are the voxels, their size and spacing (MONAI Label: position and directions
/// of the axes too), and the prompts. No name, no date, no path, and nothing else of the scene.
struct NetworkRequest {
  Volume volume;
  NetworkPrompts prompts;
  std::string network;  ///< name of a network of the server; empty: the first
};

/// Asks a server about itself. Sends nothing but the credentials. Throws Error for an invalid server, RemoteFault with
/// one line for a server that cannot be reached, refuses, or is neither of the two kinds.
NetworkInfo network_info(const NetworkServer& server, const NetworkWaiting& waiting);

/// Sends an image and prompts to a server, and returns the object of its mask at the prompts (object_at_prompts()).
/// After the loss of a lease (status 410), claims another one and sends everything again, at most twice. Throws the
/// errors of network_info() and object_at_prompts(), RemoteFault for a mask of another shape and a damaged or too
/// large response.
std::shared_ptr<const NetworkMask> segment_by_network(const NetworkServer& server, const NetworkRequest& request,
                                                      const NetworkWaiting& waiting);

}  // namespace simplexseg
