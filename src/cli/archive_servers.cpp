// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "app/table.h"
#include "cli/archive.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

struct ArchiveServersOptions {
  ArchiveOptions archive;
  std::string name, address;
  bool json = false;
};

std::string credentials_of(const ArchiveServer& server) {
  if (!server.credentials_variable.empty()) return "variable " + server.credentials_variable;
  return server.credentials_file.empty() ? "none" : "file " + server.credentials_file.string();
}

void list(const ArchiveServersOptions& options, const Console& console) {
  const std::vector<ArchiveServer> servers = read_archive_servers();
  if (options.json) {
    Json json = {{"servers", Json::array()}};
    for (const ArchiveServer& server : servers)
      json["servers"].push_back(
          {{"name", server.name}, {"address", address_of(server)}, {"timeout_s", server.timeout_s}});
    console.out << json.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
    return;
  }
  if (servers.empty()) {
    console.out << "no archive is configured; add one with: simplexseg-cli archive servers add NAME ADDRESS\n";
    return;
  }
  std::vector<std::vector<std::string>> rows = {{"name", "address", "credentials"}};
  for (const ArchiveServer& server : servers) rows.push_back({server.name, address_of(server), credentials_of(server)});
  print_table(console.out, rows, rows[0].size());
}

void add(const ArchiveServersOptions& options) {
  std::vector<ArchiveServer> servers = read_archive_servers();
  ArchiveServer server = with_options(archive_server_at(options.address), options.archive);
  server.name = options.name;
  const auto same = std::find_if(servers.begin(), servers.end(), [&](const auto& s) { return s.name == server.name; });
  if (same == servers.end())
    servers.push_back(server);
  else
    *same = server;
  write_archive_servers(servers);
}

void remove(const ArchiveServersOptions& options) {
  std::vector<ArchiveServer> servers = read_archive_servers();
  const auto gone =
      std::remove_if(servers.begin(), servers.end(), [&](const auto& s) { return s.name == options.name; });
  if (gone == servers.end())
    throw Error("the archive " + one_line(options.name), "no archive has this name",
                "list the archives with: archive servers list");
  servers.erase(gone, servers.end());
  write_archive_servers(servers);
}

void check(const ArchiveServersOptions& options, const Console& console) {
  const ArchiveServer server = server_of(options.archive);
  const std::unique_ptr<Archive> archive = open_archive(server);
  with_archive(console, "connecting", [&](const ArchiveProgress& progress) { archive->check(progress); });
  console.out << one_line(server.name) << " is reachable\n";
}

}  // namespace

void add_archive_servers(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("servers", "Manages the list of archives");
  sub.require_subcommand();
  const auto options = std::make_shared<ArchiveServersOptions>();
  const Subcommand lists = sub.add_subcommand("list", "Lists the archives");
  lists.add_flag("--json", options->json, "Print JSON");
  lists.callback([options, &action] { action = [options](const Console& console) { list(*options, console); }; });
  const Subcommand adds = sub.add_subcommand("add", "Adds an archive, or changes it");
  adds.add_option("NAME", options->name, "Name of the archive").required();
  adds.add_option("ADDRESS", options->address, "https://... for DICOMweb, TITLE@host:port for DIMSE").required();
  add_archive_connection(adds, options->archive);
  adds.callback([options, &action] { action = [options](const Console&) { add(*options); }; });
  const Subcommand removes = sub.add_subcommand("remove", "Removes an archive from the list");
  removes.add_option("NAME", options->name, "Name of the archive").required();
  removes.callback([options, &action] { action = [options](const Console&) { remove(*options); }; });
  const Subcommand checks = sub.add_subcommand("check", "Tests the connection to an archive");
  checks.add_option("NAME", options->archive.server,
                    "Name or address of the archive; optional if only one is configured");
  add_archive_connection(checks, options->archive);
  checks.callback([options, &action] { action = [options](const Console& console) { check(*options, console); }; });
}

}  // namespace simplexseg
