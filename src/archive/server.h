// SPDX-License-Identifier: Apache-2.0
// Archives (PACS) of a user, and the file that lists them.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace simplexseg {

/// Protocol of an archive.
enum class ArchiveProtocol {
  DicomWeb,  ///< QIDO-RS, WADO-RS and STOW-RS over HTTP (PS3.18)
  Dimse      ///< C-FIND, C-GET and C-STORE (PS3.4, PS3.8)
};

/// Address of an archive and identity of its user. Contains no secrets, only the place from which they are read.
struct ArchiveServer {
  std::string name;  ///< chosen by the user; no control characters, at most 64 bytes
  ArchiveProtocol protocol = ArchiveProtocol::DicomWeb;

  std::string url;  ///< DicomWeb: URL before "/studies"; http:// or https://, without user, query and fragment

  std::string host;  ///< Dimse: name or address
  int port = 104;
  std::string called_title;                  ///< Dimse: the archive's application entity title, 1 to 16 characters
  std::string calling_title = "SIMPLEXSEG";  ///< our application entity title

  /// DicomWeb over https: trusted certificates (PEM), instead of those of the system. Certificate and host name of the
  /// archive are always verified.
  std::filesystem::path ca_file;
  /// DicomWeb: environment variable or private file (mode 600) with "USER:PASSWORD" (basic) or "bearer TOKEN". At most
  /// one of both is set; both empty: no credentials.
  std::string credentials_variable;
  std::filesystem::path credentials_file;

  int timeout_s = 30;  ///< longest time without data, 1 to 3600

  friend bool operator==(const ArchiveServer&, const ArchiveServer&) = default;
};

/// Throws Error, one line with the server's name and the fault: an invalid name, URL, title or number, credentials that
/// would be sent unencrypted (http to another machine), or a URL that contains credentials.
void require_archive_server(const ArchiveServer& server);

/// Server at an address, which also becomes its name: "https://host/dicom-web", or "TITLE@host:port" for Dimse. Throws
/// Error for other texts.
ArchiveServer archive_server_at(const std::string& address);

/// Address for messages: the URL, or "TITLE@host:port".
std::string address_of(const ArchiveServer& server);

/// File that lists the servers: simplexseg/archives.json in XDG_CONFIG_HOME, else in ~/.config.
std::filesystem::path archive_servers_file();

/// Reads the servers of a file; empty if it does not exist. Throws Error for a damaged file, a name that occurs twice,
/// or an invalid server (require_archive_server()).
std::vector<ArchiveServer> read_archive_servers(const std::filesystem::path& file = archive_servers_file());

/// Writes the file of servers atomically (AtomicFile) and creates its folder. Throws Error for an invalid server, a
/// name that occurs twice, or when the file cannot be written.
void write_archive_servers(const std::vector<ArchiveServer>& servers,
                           const std::filesystem::path& file = archive_servers_file());

/// Server with that name, or at that address (archive_server_at()); for an empty name the only server. Throws Error,
/// with the known names, if there is none.
ArchiveServer find_archive_server(const std::vector<ArchiveServer>& servers, const std::string& name);

}  // namespace simplexseg
