// SPDX-License-Identifier: Apache-2.0
#include "archive/server.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"
#include "io/scene/json_input.h"
#include "io/scene/json_output.h"

namespace simplexseg {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kVersionKey = "simplexseg_archives";

bool is_title(const std::string& text) {
  return is_plain(text, 16) &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x7f && c != '\\'; });
}

ArchiveServer read_server(const JsonInput& input) {
  input.expect_keys({"name", "url", "host", "port", "called_title", "calling_title", "ca_file", "credentials_variable",
                     "credentials_file", "timeout_s"});
  ArchiveServer server;
  const auto text = [&](const char* key, const std::string& otherwise) {
    return input.has(key) ? input[key].text() : otherwise;
  };
  server.name = input["name"].text();
  if (input.has("url") == input.has("host")) input.fail("it needs either \"url\" or \"host\"", "use one of them");
  server.protocol = input.has("url") ? ArchiveProtocol::DicomWeb : ArchiveProtocol::Dimse;
  server.url = text("url", "");
  server.host = text("host", "");
  if (input.has("port")) server.port = input["port"].integer_between(1, 65535);
  server.called_title = text("called_title", "");
  server.calling_title = text("calling_title", server.calling_title);
  server.ca_file = text("ca_file", "");
  server.credentials_variable = text("credentials_variable", "");
  server.credentials_file = text("credentials_file", "");
  if (input.has("timeout_s")) server.timeout_s = input["timeout_s"].integer_between(1, 3600);
  require_archive_server(server);
  return server;
}

Json json_of(const ArchiveServer& server) {
  Json json = {{"name", server.name}};
  if (server.protocol == ArchiveProtocol::DicomWeb) {
    json["url"] = server.url;
    for (const auto& [key, value] :
         {std::pair("ca_file", server.ca_file.string()), std::pair("credentials_variable", server.credentials_variable),
          std::pair("credentials_file", server.credentials_file.string())})
      if (!value.empty()) json[key] = value;
  } else {
    json["host"] = server.host, json["port"] = server.port;
    json["called_title"] = server.called_title, json["calling_title"] = server.calling_title;
  }
  json["timeout_s"] = server.timeout_s;
  return json;
}

void require_distinct(const std::vector<ArchiveServer>& servers, const fs::path& file) {
  std::set<std::string> names;
  for (const ArchiveServer& server : servers)
    if (!names.insert(server.name).second)
      throw Error("the archives in " + quoted(file), "two have the name " + one_line(server.name), "rename one");
}

}  // namespace

void require_archive_server(const ArchiveServer& server) {
  const WebServer web = web_server_of(server);
  require_server_settings(web, server.name);
  if (server.protocol == ArchiveProtocol::DicomWeb) return require_web_server(web, "https://host/dicom-web");
  if (!is_host(server.host) || server.port < 1 || server.port > 65535)
    throw Error(web.what, "its host or its port is invalid", "use an address such as ORTHANC@localhost:4242");
  if (!is_title(server.called_title) || !is_title(server.calling_title))
    throw Error(web.what, "one of its AE titles is not 1 to 16 ASCII characters without a backslash",
                "ask your PACS administrator for the titles");
  if (!server.credentials_variable.empty() || !server.credentials_file.empty() || !server.ca_file.empty())
    throw Error(web.what, "only DICOMweb uses credentials and certificates", "omit them");
}

ArchiveServer archive_server_at(const std::string& address) {
  ArchiveServer server;
  server.name = address;
  if (address.find("://") != std::string::npos) {
    server.url = address;
    while (server.url.ends_with('/')) server.url.pop_back();
  } else {
    const std::size_t at = address.find('@'), colon = address.rfind(':');
    const std::string digits = colon == std::string::npos ? "" : address.substr(colon + 1);
    if (at == std::string::npos || colon == std::string::npos || colon < at || digits.empty() || digits.size() > 5 ||
        !std::all_of(digits.begin(), digits.end(), is_ascii_digit))
      throw Error("the archive " + one_line(address), "it is not an address", "use https://... or TITLE@host:port");
    server.protocol = ArchiveProtocol::Dimse;
    server.called_title = address.substr(0, at);
    server.host = address.substr(at + 1, colon - at - 1);
    server.port = static_cast<int>(*parse_integer(digits));
  }
  server.name = address_of(server);
  require_archive_server(server);
  return server;
}

WebServer web_server_of(const ArchiveServer& server) {
  return {"the archive " + one_line(server.name),
          "an archive",
          "ask your PACS administrator",
          address_of(server),
          server.ca_file,
          server.credentials_variable,
          server.credentials_file,
          server.timeout_s};
}

std::string address_of(const ArchiveServer& server) {
  return server.protocol == ArchiveProtocol::DicomWeb
             ? server.url
             : server.called_title + "@" + server.host + ":" + std::to_string(server.port);
}

fs::path archive_servers_file() { return server_list_file("archives.json"); }

std::vector<ArchiveServer> read_archive_servers(const fs::path& file) {
  std::vector<ArchiveServer> servers;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return servers;
  const JsonInput input = JsonInput::open(file, "list of archives");
  input.expect_keys({kVersionKey, "servers"});
  input[kVersionKey].integer_between(1, 1);
  const JsonInput list = input["servers"];
  for (int n = 0; n < list.size(); ++n) servers.push_back(read_server(list[n]));
  require_distinct(servers, file);
  return servers;
}

void write_archive_servers(const std::vector<ArchiveServer>& servers, const fs::path& file) {
  require_distinct(servers, file);
  Json json = {{kVersionKey, 1}, {"servers", Json::array()}};
  for (const ArchiveServer& server : servers) {
    require_archive_server(server);
    json["servers"].push_back(json_of(server));
  }
  std::error_code ignored;
  fs::create_directories(file.parent_path(), ignored);  // AtomicFile reports a missing folder
  AtomicFile out(file);
  write_bytes(out, json_text(file, json));
  out.commit();
}

ArchiveServer find_archive_server(const std::vector<ArchiveServer>& servers, const std::string& name) {
  if (name.empty() && servers.size() == 1) return servers.front();
  for (const ArchiveServer& server : servers)
    if (server.name == name) return server;
  if (name.find('@') != std::string::npos || name.find("://") != std::string::npos) return archive_server_at(name);
  std::string known;
  for (const ArchiveServer& server : servers) known += (known.empty() ? "" : ", ") + one_line(server.name);
  throw Error(
      name.empty() ? "the archive" : "the archive " + one_line(name),
      name.empty() ? "none is selected" : "the list of archives has no such name",
      known.empty() ? "add one first, or use its address: https://... or TITLE@host:port" : "choose one of: " + known);
}

}  // namespace simplexseg
