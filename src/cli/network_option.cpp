// SPDX-License-Identifier: Apache-2.0
#include "cli/network_option.h"

#include <ostream>

#include "app/progress.h"
#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/scene/mesh_start.h"
#include "session/scene_checks.h"

namespace simplexseg {
namespace {

NetworkServer server_of(const NetworkOptions& options) {
  NetworkServer server = find_network_server(read_network_servers(), options.server);
  set_connection(server, options.connection);
  require_network_server(server);
  return server;
}

}  // namespace

void add_network_options(const Subcommand& sub, NetworkOptions& options) {
  sub.add_option("--network", options.server,
                 "Segmentation server (nnInteractive or MONAI Label): its URL, or its name in networks.json. The image "
                 "and the points of each mesh are sent to it; its mask is the start of the mesh and a prior")
      .not_empty();
  sub.add_option("--network-name", options.network, "Network of the server; default: its first one").not_empty();
  sub.add_option("--network-error", options.error_mm,
                 "Expected error of the surface of the mask (standard deviation), mm")
      .within(kMinNetworkErrorMm, kMaxErrorMm)
      .show_default();
  add_connection_options(sub, options.connection, NetworkServer().timeout_s);
}

std::vector<Command> starts_from_network(const NetworkOptions& options, const Scene& scene, const Volume& volume,
                                         const Console& console) {
  if (volume.empty()) throw Error("--network", "there is no image", "name one");
  for (const MeshItem& item : scene.meshes) {  // before anything is sent
    if (item.start) throw Error("--network", "'" + item.name + "' starts from labels", "omit one of the two");
    check_network_start(item);
  }
  const NetworkServer server = server_of(options);
  const Interrupt interrupt;
  const NetworkWaiting waiting = [] { Interrupt::check(); };
  try {
    const NetworkInfo info = network_info(server, waiting);
    std::vector<Command> commands;
    for (const MeshItem& item : scene.meshes) {
      NetworkRequest request{volume, prompts_of(scene, item, volume.geometry(), info.scribble_voxels), options.network};
      console.err << "note: sends the image (" << format_bytes(static_cast<double>(volume.bytes())) << ") and "
                  << text_of(request.prompts) << " of '" << one_line(item.name, 100) << "' to " << server.url << " ("
                  << name_of(info.protocol)
                  << "); licence of its network: " << (info.licence.empty() ? "not stated" : info.licence) << "\n";
      const Progress progress(console, "network");
      commands.emplace_back(
          SetStart{item.id, start_of_network(segment_by_network(server, request, waiting), options.error_mm).start});
    }
    return commands;
  } catch (const RemoteFault& fault) {
    throw Failure(fault.what());
  }
}

}  // namespace simplexseg
