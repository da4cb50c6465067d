// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "cli/archive.h"
#include "cli/table.h"
#include "io/files.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  ArchiveOptions archive;
  std::string name, address;
  bool json = false;
};

std::string credentials_of(const ArchiveServer& server) {
  if (!server.credentials_variable.empty()) return "variable " + server.credentials_variable;
  return server.credentials_file.empty() ? "none" : "file " + server.credentials_file.string();
}

void list(const Options& options, const Console& console) {
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
    console.out << "no archive: add one by archive servers add NAME ADDRESS\n";
    return;
  }
  std::vector<std::vector<std::string>> rows = {{"name", "address", "credentials"}};
  for (const ArchiveServer& server : servers) rows.push_back({server.name, address_of(server), credentials_of(server)});
  print_table(console.out, rows, rows[0].size());
}

void add(const Options& options) {
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

void remove(const Options& options) {
  std::vector<ArchiveServer> servers = read_archive_servers();
  const auto gone =
      std::remove_if(servers.begin(), servers.end(), [&](const auto& s) { return s.name == options.name; });
  if (gone == servers.end())
    throw Error("the archive " + one_line(options.name), "there is none of that name", "see archive servers list");
  servers.erase(gone, servers.end());
  write_archive_servers(servers);
}

void check(const Options& options, const Console& console) {
  const ArchiveServer server = server_of(options.archive);
  const std::unique_ptr<Archive> archive = open_archive(server);
  with_archive(console, "asking", [&](const ArchiveProgress& progress) { archive->check(progress); });
  console.out << one_line(server.name) << " answers\n";
}

}  // namespace

void add_archive_servers(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("servers", "The archives that are known by name");
  sub.require_subcommand();
  const auto options = std::make_shared<Options>();
  const Subcommand lists = sub.add_subcommand("list", "Lists them");
  lists.add_flag("--json", options->json, "Print JSON");
  lists.callback([options, &action] { action = [options](const Console& console) { list(*options, console); }; });
  const Subcommand adds = sub.add_subcommand("add", "Adds one, or changes it");
  adds.add_option("NAME", options->name, "What it is to be called").required();
  adds.add_option("ADDRESS", options->address, "https://... for DICOMweb, or TITLE@host:port").required();
  add_connection_options(adds, options->archive);
  adds.callback([options, &action] { action = [options](const Console&) { add(*options); }; });
  const Subcommand removes = sub.add_subcommand("remove", "Removes one");
  removes.add_option("NAME", options->name, "Its name").required();
  removes.callback([options, &action] { action = [options](const Console&) { remove(*options); }; });
  const Subcommand checks = sub.add_subcommand("check", "Asks one whether it answers");
  checks.add_option("NAME", options->archive.server, "Its name or address; may be left out where there is one");
  add_connection_options(checks, options->archive);
  checks.callback([options, &action] { action = [options](const Console& console) { check(*options, console); }; });
}

}  // namespace simplexseg
