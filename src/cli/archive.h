// SPDX-License-Identifier: Apache-2.0
// Shared options and functions of the subcommands of `archive`.
#pragma once
#include <functional>
#include <string>

#include "archive/archive.h"
#include "cli/connection_options.h"

namespace simplexseg {

/// Options that select an archive and its connection.
struct ArchiveOptions {
  std::string server;  ///< name or address; empty: the only configured archive
  ConnectionOptions connection;
  std::string calling_title;
};

/// Adds `--server` and the connection options.
void add_archive_options(const Subcommand& sub, ArchiveOptions& options);
/// Adds the connection options only.
void add_archive_connection(const Subcommand& sub, ArchiveOptions& options);
/// Returns the selected server with the connection options. Throws Error for an unknown server. Options that the
/// protocol does not support are rejected by open_archive().
ArchiveServer server_of(const ArchiveOptions& options);
/// Returns `server` with the connection options that are set.
ArchiveServer with_options(ArchiveServer server, const ArchiveOptions& options);
/// Calls `work` and shows its progress on a terminal; Ctrl+C cancels it. Converts an ArchiveFault to a Failure.
void with_archive(const Console& console, const std::string& activity,
                  const std::function<void(const ArchiveProgress&)>& work);

// Each function adds one subcommand.
void add_archive_find(const Subcommand& app, Action& action);
void add_archive_get(const Subcommand& app, Action& action);
void add_archive_send(const Subcommand& app, Action& action);
void add_archive_servers(const Subcommand& app, Action& action);

}  // namespace simplexseg
