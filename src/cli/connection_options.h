// SPDX-License-Identifier: Apache-2.0
// Options of the connection to a server: an archive or a segmentation server.
#pragma once
#include <filesystem>
#include <string>

#include "cli/commands.h"

namespace simplexseg {

/// Options of a connection; empty and 0: as the list of servers states.
struct ConnectionOptions {
  std::string ca_file, credentials_variable, credentials_file;
  int timeout_s = 0;  ///< time-out, s
};

/// Adds the options of a connection. `default_s`: time-out of a server without one, for the help.
void add_connection_options(const Subcommand& sub, ConnectionOptions& options, int default_s);

/// Sets what the options state in a server. `Server` has the members of WebServer of these names.
template <class Server>
void set_connection(Server& server, const ConnectionOptions& options) {
  const auto absolute = [](const std::string& path) {
    return path.empty() ? std::filesystem::path() : std::filesystem::absolute(path);
  };
  if (!options.ca_file.empty()) server.ca_file = absolute(options.ca_file);
  if (!options.credentials_variable.empty() || !options.credentials_file.empty()) {
    server.credentials_variable = options.credentials_variable;
    server.credentials_file = absolute(options.credentials_file);
  }
  if (options.timeout_s > 0) server.timeout_s = options.timeout_s;
}

}  // namespace simplexseg
