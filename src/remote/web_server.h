// SPDX-License-Identifier: Apache-2.0
// Server that this program calls over HTTP: an archive or a segmentation server.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/error.h"

namespace simplexseg {

/// Address of a server, and words for messages. Contains no secrets, only the place from which they are read.
struct WebServer {
  std::string what;           ///< for messages, for example "the archive ward"
  std::string kind;           ///< for messages, for example "an archive"
  std::string administrator;  ///< remedy for refusals, for example "ask your PACS administrator"
  std::string url;  ///< URL before the paths of requests; http:// or https://, without user, query and fragment
  /// https: file of trusted certificates (PEM), used instead of those of the system; empty: those of the system. The
  /// certificate and host name of the server are always verified.
  std::filesystem::path ca_file;
  /// Environment variable or private file (mode 600) that contains "USER:PASSWORD" (basic authentication) or "bearer
  /// TOKEN". At most one of the two is set; both empty: no credentials.
  std::string credentials_variable;
  std::filesystem::path credentials_file;
  int timeout_s = 30;  ///< longest time without data, s
};

/// Failure of a server or of the network; the same call may succeed later. Invalid input throws another Error.
class RemoteFault : public Error {
 public:
  using Error::Error;
};

/// Throws Error for an invalid URL, a URL that contains credentials, and credentials that would be sent unencrypted
/// (http to another machine). `example`: valid URL for messages.
void require_web_server(const WebServer& server, const std::string& example);

/// Throws Error for a name that is not plain text of at most 64 bytes or the URL, a time-out outside 1 to 3600 s, and
/// two places with credentials. `what` of `server` begins the message.
void require_server_settings(const WebServer& server, const std::string& name);

/// Path of a list of servers: simplexseg/NAME in XDG_CONFIG_HOME, else in ~/.config.
std::filesystem::path server_list_file(const std::string& name);

/// Whether a host is this machine: "localhost" or a loopback address, IPv6 also in brackets.
bool is_own_host(const std::string& host);
/// Whether the host of a valid URL is this machine.
bool is_own_url(const std::string& url);
/// Whether nobody can read what is sent on its way to a valid URL: https, or a server of this machine.
bool is_protected(const std::string& url);
/// Whether a text is a host name or an IP address.
bool is_host(const std::string& text);
/// Whether a text has 1 to `max_size` bytes, no control characters and no blanks at its ends.
bool is_plain(const std::string& text, std::size_t max_size);

/// Fault with the server's name, the cause `why` and the remedy `what_to_do`.
RemoteFault remote_fault(const WebServer& server, const std::string& why, const std::string& what_to_do);

// Faults common to all protocols. `during`: phase in which the connection was lost, for example "during sending";
// `what`: name of the object that is too large; `limit`: largest size, bytes.
RemoteFault connection_refused(const WebServer& server);
RemoteFault unknown_host(const WebServer& server);
RemoteFault timed_out(const WebServer& server);
RemoteFault connection_lost(const WebServer& server, const std::string& during);
RemoteFault too_large(const WebServer& server, const std::string& what, std::uint64_t limit,
                      const std::string& what_to_do);

}  // namespace simplexseg
