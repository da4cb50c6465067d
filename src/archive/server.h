// SPDX-License-Identifier: Apache-2.0
// Archives (PACS) of a user, and the file that lists them.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "remote/web_server.h"

namespace simplexseg {

/// Protocol of an archive.
enum class ArchiveProtocol {
  DicomWeb,  ///< QIDO-RS, WADO-RS and STOW-RS over HTTP (PS3.18)
  Dimse      ///< C-FIND, C-GET and C-STORE (PS3.4, PS3.8)
};

/// Address of an archive and identity of this program. Contains no secrets, only the place from which they are read.
struct ArchiveServer {
  std::string name;  ///< chosen by the user, at most 64 bytes, or the address; no control characters
  ArchiveProtocol protocol = ArchiveProtocol::DicomWeb;

  std::string url;  ///< DicomWeb: URL before "/studies"; http:// or https://, without user, query and fragment

  std::string host;  ///< Dimse: host name or IP address
  int port = 104;
  std::string called_title;                  ///< Dimse: application entity title of the archive, 1 to 16 characters
  std::string calling_title = "SIMPLEXSEG";  ///< Dimse: application entity title of this program

  /// DicomWeb over https: file of trusted certificates (PEM), used instead of those of the system; empty: those of the
  /// system. The certificate and host name of the archive are always verified.
  std::filesystem::path ca_file;
  /// DicomWeb: environment variable or private file (mode 600) that contains "USER:PASSWORD" (basic authentication) or
  /// "bearer TOKEN". At most one of the two is set; both empty: no credentials.
  std::string credentials_variable;
  std::filesystem::path credentials_file;

  int timeout_s = 30;  ///< longest time without data, 1 to 3600 s

  friend bool operator==(const ArchiveServer&, const ArchiveServer&) = default;
};

/// Throws Error for an invalid name, URL, host, title or number, credentials that would be sent unencrypted (http to
/// another machine), a URL that contains credentials, or credentials and certificates for Dimse.
void require_archive_server(const ArchiveServer& server);

/// Server at an address, which also becomes the server's name: "https://host/dicom-web", or "TITLE@host:port" for
/// Dimse. Throws Error for an invalid address.
ArchiveServer archive_server_at(const std::string& address);

/// Server of requests over HTTP, with the words for messages. For Dimse, its URL is address_of(), for messages alone.
WebServer web_server_of(const ArchiveServer& server);

/// Address of a server for messages: the URL, or "TITLE@host:port" for Dimse.
std::string address_of(const ArchiveServer& server);

/// Path of the file that lists the servers: simplexseg/archives.json in XDG_CONFIG_HOME, else in ~/.config.
std::filesystem::path archive_servers_file();

/// Reads the servers of a file; none if the file does not exist. Throws Error for a damaged file, a name that occurs
/// twice, or an invalid server (require_archive_server()).
std::vector<ArchiveServer> read_archive_servers(const std::filesystem::path& file = archive_servers_file());

/// Writes the file of servers atomically (AtomicFile) and creates its folder. Throws Error for an invalid server, a
/// name that occurs twice, or when the file cannot be written.
void write_archive_servers(const std::vector<ArchiveServer>& servers,
                           const std::filesystem::path& file = archive_servers_file());

/// Server with a name, or at an address (archive_server_at()); for an empty name, the only server in the list. Throws
/// Error, with the known names, if there is no such server.
ArchiveServer find_archive_server(const std::vector<ArchiveServer>& servers, const std::string& name);

}  // namespace simplexseg
