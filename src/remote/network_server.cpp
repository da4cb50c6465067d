// SPDX-License-Identifier: Apache-2.0
#include "remote/network_server.h"

#include <algorithm>
#include <set>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/scene/json_input.h"
#include "remote/network_calls.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

constexpr const char* kVersionKey = "simplexseg_networks";

NetworkServer read_server(const JsonInput& input) {
  input.expect_keys({"name", "url", "ca_file", "credentials_variable", "credentials_file", "timeout_s"});
  NetworkServer server;
  server.name = input["name"].text();
  server.url = input["url"].text();
  if (input.has("ca_file")) server.ca_file = input["ca_file"].text();
  if (input.has("credentials_variable")) server.credentials_variable = input["credentials_variable"].text();
  if (input.has("credentials_file")) server.credentials_file = input["credentials_file"].text();
  if (input.has("timeout_s")) server.timeout_s = input["timeout_s"].integer_between(1, 3600);
  require_network_server(server);
  return server;
}

}  // namespace

WebServer web_server_of(const NetworkServer& server) {
  return {"the segmentation server " + one_line(server.name),
          "a segmentation server",
          "ask its administrator",
          server.url,
          server.ca_file,
          server.credentials_variable,
          server.credentials_file,
          server.timeout_s};
}

void require_network_server(const NetworkServer& server) {
  const WebServer web = web_server_of(server);
  require_server_settings(web, server.name);
  require_web_server(web, "https://host:1527");
}

fs::path network_servers_file() { return server_list_file("networks.json"); }

std::vector<NetworkServer> read_network_servers(const fs::path& file) {
  std::vector<NetworkServer> servers;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return servers;
  const JsonInput input = JsonInput::open(file, "list of segmentation servers");
  input.expect_keys({kVersionKey, "servers"});
  input[kVersionKey].integer_between(1, 1);
  const JsonInput list = input["servers"];
  std::set<std::string> names;
  for (int n = 0; n < list.size(); ++n) {
    servers.push_back(read_server(list[n]));
    if (!names.insert(servers.back().name).second)
      list[n].fail("two servers have the name " + one_line(servers.back().name), "rename one");
  }
  return servers;
}

NetworkServer find_network_server(const std::vector<NetworkServer>& servers, const std::string& name) {
  const auto found = std::ranges::find(servers, name, &NetworkServer::name);
  if (found != servers.end()) return *found;
  if (name.find("://") != std::string::npos || name.find('@') != std::string::npos) {
    NetworkServer server;
    server.url = name;
    while (server.url.ends_with('/')) server.url.pop_back();
    server.name = server.url;
    require_network_server(server);
    return server;
  }
  std::string known;
  for (const NetworkServer& server : servers) known += (known.empty() ? "" : ", ") + one_line(server.name);
  throw Error("the segmentation server " + one_line(name), "the list of servers has no such name",
              known.empty() ? "use its address, such as https://host:1527" : "choose one of: " + known);
}

const char* name_of(NetworkInfo::Protocol protocol) {
  return protocol == NetworkInfo::Protocol::NnInteractive ? "nnInteractive" : "MONAI Label";
}

}  // namespace simplexseg
