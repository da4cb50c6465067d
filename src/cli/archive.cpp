// SPDX-License-Identifier: Apache-2.0
#include "cli/archive.h"

#include "app/progress.h"
#include "io/platform/load_progress.h"

namespace simplexseg {

void add_archive_connection(const Subcommand& sub, ArchiveOptions& options) {
  add_connection_options(sub, options.connection, ArchiveServer().timeout_s);
  sub.add_option("--calling-title", options.calling_title,
                 "Application entity title of this program (DIMSE); default: SIMPLEXSEG");
}

void add_archive_options(const Subcommand& sub, ArchiveOptions& options) {
  sub.add_option(
      "--server", options.server,
      "Name of an archive (list the archives with: archive servers list) or its address: https://... for DICOMweb, "
      "TITLE@host:port for DIMSE; optional if only one archive is configured");
  add_archive_connection(sub, options);
}

ArchiveServer with_options(ArchiveServer server, const ArchiveOptions& options) {
  set_connection(server, options.connection);
  if (!options.calling_title.empty()) server.calling_title = options.calling_title;
  return server;
}

ArchiveServer server_of(const ArchiveOptions& options) {
  return with_options(find_archive_server(read_archive_servers(), options.server), options);
}

void with_archive(const Console& console, const std::string& activity,
                  const std::function<void(const ArchiveProgress&)>& work) {
  const Interrupt interrupt;
  try {
    Progress progress(console, activity);
    work([&](const ArchiveTransfer& transfer) {
      Interrupt::check();
      if (transfer.total > 0) progress.set(double(transfer.instances) / transfer.total);
      return true;
    });
  } catch (const ArchiveFault& fault) {
    throw Failure(fault.what());
  }
}

void add_archive(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("archive", "Searches a DICOM archive (PACS), downloads series from it and sends files to it");
  sub.require_subcommand();
  add_archive_find(sub, action);
  add_archive_get(sub, action);
  add_archive_send(sub, action);
  add_archive_servers(sub, action);
}

}  // namespace simplexseg
