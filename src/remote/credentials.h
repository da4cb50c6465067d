// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "remote/web_server.h"

namespace simplexseg {

/// Credentials of a user, in memory only during a call to a server. They are never part of a message.
struct Credentials {
  std::string basic;   ///< "USER:PASSWORD", or empty
  std::string bearer;  ///< token, or empty
};

/// Contents of a file with a secret, without line breaks at its end; at most 16 KiB are read. Throws Error, without any
/// part of the contents, for a file that is missing, accessible to others or owned by another user. `what`: beginning
/// of the message, which continues with the path.
std::string read_secret_file(const std::filesystem::path& path, const std::string& what);

/// Reads the credentials of a server from the environment variable or file that it names; empty if it names neither.
/// Throws Error, without any part of the credentials, for an unset variable, a file that is missing, accessible to
/// others or owned by another user, and a text that is neither "USER:PASSWORD" nor "bearer TOKEN".
Credentials read_credentials(const WebServer& server);

}  // namespace simplexseg
