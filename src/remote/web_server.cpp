// SPDX-License-Identifier: Apache-2.0
#include "remote/web_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstdlib>

#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

/// Host of a URL, without the port.
std::string host_of_url(const std::string& url) {
  const std::size_t start = url.find("//") + 2;
  std::string host = url.substr(start, url.find('/', start) - start);
  if (const std::size_t bracket = host.find(']'); bracket != std::string::npos) return host.substr(0, bracket + 1);
  return host.substr(0, host.find(':'));
}

/// Whether a text that should be a URL names a user before its host.
bool has_user(const std::string& text) {
  const std::size_t slashes = text.find("//"), start = slashes == std::string::npos ? 0 : slashes + 2;
  return text.substr(start, text.find('/', start) - start).find('@') != std::string::npos;
}

}  // namespace

bool is_own_host(const std::string& host) {
  constexpr unsigned kLoopbackNet = 127;
  const bool has_brackets = host.size() > 2 && host.front() == '[' && host.back() == ']';
  const std::string address = has_brackets ? host.substr(1, host.size() - 2) : host;
  in_addr four{};
  in6_addr six{};
  if (inet_pton(AF_INET, address.c_str(), &four) == 1) return ntohl(four.s_addr) >> 24 == kLoopbackNet;
  if (inet_pton(AF_INET6, address.c_str(), &six) == 1) return IN6_IS_ADDR_LOOPBACK(&six);
  return host == "localhost";
}

bool is_own_url(const std::string& url) { return is_own_host(host_of_url(url)); }
bool is_protected(const std::string& url) { return url.starts_with("https://") || is_own_url(url); }

bool is_plain(const std::string& text, std::size_t max_size) {
  return !text.empty() && text.size() <= max_size && text.front() != ' ' && text.back() != ' ' &&
         std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

bool is_host(const std::string& text) {
  return is_plain(text, 253) && std::all_of(text.begin(), text.end(), [](char c) {
           return is_ascii_letter(c) || is_ascii_digit(c) ||
                  std::string_view(".-_:[]").find(c) != std::string_view::npos;
         });
}

void require_web_server(const WebServer& server, const std::string& example) {
  const std::string& url = server.url;
  const std::string use = "use an address such as " + example;
  if (has_user(url))  // first, since other messages contain the name, which may be the URL
    throw Error("the address of " + server.kind, "it contains a user or a password",
                "use a variable or a file for them instead");
  if (!url.starts_with("https://") && !url.starts_with("http://"))
    throw Error(server.what, url.empty() ? "it has no URL" : "its URL does not begin with https:// or http://", use);
  if (!is_plain(url, 2000) || url.find_first_of(" \"\\<>^`{|}?#") != std::string::npos || !is_host(host_of_url(url)))
    throw Error(server.what, "its URL is invalid, or has a query or a fragment", use);
  const bool has_credentials = !server.credentials_variable.empty() || !server.credentials_file.empty();
  if (has_credentials && !is_protected(url))
    throw Error(server.what, "http would send its credentials unencrypted", "use https");
}

RemoteFault remote_fault(const WebServer& server, const std::string& why, const std::string& what_to_do) {
  return RemoteFault(server.what, why, what_to_do);
}
RemoteFault connection_refused(const WebServer& server) {
  return remote_fault(server, "it refused the connection at " + server.url,
                      "check its host and port, and that it is running");
}
RemoteFault unknown_host(const WebServer& server) {
  return remote_fault(server, "the host is unknown: " + server.url, "check the name and the network");
}
RemoteFault timed_out(const WebServer& server) {
  return remote_fault(server, "time-out: no data for " + std::to_string(server.timeout_s) + " s",
                      "try again, or set a longer time-out");
}
RemoteFault connection_lost(const WebServer& server, const std::string& during) {
  return remote_fault(server, "the connection ended " + during, "try again");
}
RemoteFault too_large(const WebServer& server, const std::string& what, std::uint64_t limit,
                      const std::string& what_to_do) {
  return remote_fault(
      server, what + " is larger than " + format_bytes(static_cast<double>(limit)) + " and was cancelled", what_to_do);
}

void require_server_settings(const WebServer& server, const std::string& name) {
  if (!is_plain(name, name == server.url ? 2000 : 64))
    throw Error(server.what, "its name is empty, too long or has blanks at its ends",
                "use a name of at most 64 characters");
  if (server.timeout_s < 1 || server.timeout_s > 3600)
    throw Error(server.what, "its time-out is " + std::to_string(server.timeout_s) + " s", "use 1 to 3600 s");
  if (!server.credentials_variable.empty() && !server.credentials_file.empty())
    throw Error(server.what, "it has both a variable and a file with credentials", "use one of them");
}

std::filesystem::path server_list_file(const std::string& name) {
  const char* const config = std::getenv("XDG_CONFIG_HOME");
  const char* const home = std::getenv("HOME");
  const std::filesystem::path folder =
      config && *config == '/' ? std::filesystem::path(config) : std::filesystem::path(home ? home : "/") / ".config";
  return folder / "simplexseg" / name;
}

}  // namespace simplexseg
