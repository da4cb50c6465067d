// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "cli/connection_options.h"
#include "remote/network_calls.h"
#include "session/command.h"

namespace simplexseg {

/// Options that select a segmentation server (docs/networks.md).
struct NetworkOptions {
  std::string server;  ///< name or URL; empty: none
  std::string network;
  ConnectionOptions connection;
  double error_mm = kNetworkErrorMm;
};

void add_network_options(const Subcommand& sub, NetworkOptions& options);

/// Sends the volume and the prompts of each mesh to the server, and returns the commands that start the meshes from its
/// masks. States before what is sent to whom, and the licence of the network. Ctrl+C cancels the call. Throws Failure
/// for a RemoteFault.
std::vector<Command> starts_from_network(const NetworkOptions& options, const Scene& scene, const Volume& volume,
                                         const Console& console);

}  // namespace simplexseg
