// SPDX-License-Identifier: Apache-2.0
// What the subcommands of `archive` have in common.
#pragma once
#include <functional>
#include <string>

#include "archive/archive.h"
#include "cli/commands.h"

namespace simplexseg {

/// Which archive, as the command line says it.
struct ArchiveOptions {
  std::string server;  ///< name or address
  std::string ca_file, credentials_variable, credentials_file, calling_title;
  int timeout_s = 0;  ///< 0: as the server has it
};

void add_archive_options(const Subcommand& sub, ArchiveOptions& options);
/// The same but for the server itself.
void add_connection_options(const Subcommand& sub, ArchiveOptions& options);
/// Throws Error where there is none of that name, or the options do not go with it.
ArchiveServer server_of(const ArchiveOptions& options);
/// The server with what the options say.
ArchiveServer with_options(ArchiveServer server, const ArchiveOptions& options);
/// Calls `work`, with progress on a terminal; Ctrl+C calls it off. A fault of the archive becomes a Failure.
void with_archive(const Console& console, const std::string& doing,
                  const std::function<void(const ArchiveProgress&)>& work);

// Each adds one subcommand.
void add_archive_find(const Subcommand& app, Action& action);
void add_archive_get(const Subcommand& app, Action& action);
void add_archive_send(const Subcommand& app, Action& action);
void add_archive_servers(const Subcommand& app, Action& action);

}  // namespace simplexseg
