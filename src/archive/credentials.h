// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "archive/server.h"

namespace simplexseg {

/// Credentials of a user. They exist only during a connection and are never part of a message.
struct Credentials {
  std::string basic;   ///< "USER:PASSWORD", or empty
  std::string bearer;  ///< token, or empty
};

/// Reads the credentials of a server from its variable or file; empty if it has neither. Throws Error, without any part
/// of them, for an unset variable, a file that is missing, readable by others or owned by another user, and for a text
/// that is neither "USER:PASSWORD" nor "bearer TOKEN".
Credentials read_credentials(const ArchiveServer& server);

}  // namespace simplexseg
