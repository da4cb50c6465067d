// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "archive/server.h"

namespace simplexseg {

/// What a user proves itself by. It is held as short as can be, and goes into no message.
struct Credentials {
  std::string basic;   ///< "USER:PASSWORD", or empty
  std::string bearer;  ///< token, or empty
};

/// Those of a server, from its variable or its file; none where it names neither. Throws Error, without any part of
/// them, where the variable is not set, or the file is missing, others may read it, or it is not its user's; or they
/// are neither "USER:PASSWORD" nor "bearer TOKEN".
Credentials read_credentials(const ArchiveServer& server);

}  // namespace simplexseg
