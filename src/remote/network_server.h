// SPDX-License-Identifier: Apache-2.0
// Segmentation servers of a user, and the file that lists them (docs/networks.md).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "remote/web_server.h"

namespace simplexseg {

/// Address of a segmentation server. Contains no secrets, only the place from which they are read.
struct NetworkServer {
  std::string name;               ///< chosen by the user, at most 64 bytes, or the URL; no control characters
  std::string url;                ///< WebServer::url
  std::filesystem::path ca_file;  ///< WebServer::ca_file
  std::string credentials_variable;
  std::filesystem::path credentials_file;  ///< see WebServer::credentials_file
  int timeout_s = 300;  ///< longest time without data, during which the network computes, 1 to 3600 s
};

/// Server of requests, with the words for messages.
WebServer web_server_of(const NetworkServer& server);

/// Throws Error for an invalid name, URL or number, and for credentials that would be sent unencrypted.
void require_network_server(const NetworkServer& server);

/// Path of the file that lists the servers: simplexseg/networks.json in XDG_CONFIG_HOME, else in ~/.config.
std::filesystem::path network_servers_file();
/// Reads the servers of a file; none if the file does not exist. Throws Error for a damaged file, a name that occurs
/// twice, or an invalid server.
std::vector<NetworkServer> read_network_servers(const std::filesystem::path& file = network_servers_file());
/// Server with a name, or at a URL. Throws Error, with the known names, if there is no such server.
NetworkServer find_network_server(const std::vector<NetworkServer>& servers, const std::string& name);

}  // namespace simplexseg
