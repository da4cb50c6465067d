// SPDX-License-Identifier: Apache-2.0
// The archives (PACS) that a user has named, and the file in which they are kept.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace simplexseg {

/// How an archive is talked to.
enum class ArchiveProtocol {
  DicomWeb,  ///< QIDO-RS, WADO-RS and STOW-RS over HTTP (PS3.18)
  Dimse      ///< C-FIND, C-GET and C-STORE over DICOM's own connections (PS3.4, PS3.8)
};

/// Where an archive is, and by what its user is known there. It holds no secret: only where one is read from.
struct ArchiveServer {
  std::string name;  ///< by which the user calls it; without control characters, 64 bytes at most
  ArchiveProtocol protocol = ArchiveProtocol::DicomWeb;

  std::string url;  ///< DicomWeb: what comes before "/studies"; http:// or https://, without user, query and fragment

  std::string host;  ///< Dimse: name or address
  int port = 104;
  std::string called_title;                  ///< Dimse: the archive's application entity title, 1 to 16 characters
  std::string calling_title = "SIMPLEXSEG";  ///< ours, as the archive knows it

  /// DicomWeb over https: certificates (PEM) that are trusted instead of the system's. The archive's certificate and
  /// its name are always verified.
  std::filesystem::path ca_file;
  /// DicomWeb: the environment variable, or else the file (of its user alone, mode 600), with "USER:PASSWORD" (basic)
  /// or "bearer TOKEN". Both empty: none. At most one is given.
  std::string credentials_variable;
  std::filesystem::path credentials_file;

  int timeout_s = 30;  ///< how long nothing may come before an answer counts as lost; 1 to 3600

  friend bool operator==(const ArchiveServer&, const ArchiveServer&) = default;
};

/// Throws Error, one line that names the server and what is wrong with it: a name, URL, title or number that cannot be,
/// credentials that would go out unencrypted (http to another machine), or a URL that holds them.
void require_archive_server(const ArchiveServer& server);

/// A server that is given as an address rather than by name: "https://host/dicom-web", or "TITLE@host:port" for Dimse.
/// Its name is the address. Throws Error for anything else.
ArchiveServer archive_server_at(const std::string& address);

/// Its address for people: the URL, or "TITLE@host:port".
std::string address_of(const ArchiveServer& server);

/// The file of servers: simplexseg/archives.json in the user's folder of settings (XDG_CONFIG_HOME, else ~/.config).
std::filesystem::path archive_servers_file();

/// The servers of a file; none where it does not exist. Throws Error where it is damaged, names a server twice, or
/// one is refused by require_archive_server().
std::vector<ArchiveServer> read_archive_servers(const std::filesystem::path& file = archive_servers_file());

/// Writes them, whole or not at all (AtomicFile), and makes the folder. Throws Error as reading does, or when the file
/// cannot be written.
void write_archive_servers(const std::vector<ArchiveServer>& servers,
                           const std::filesystem::path& file = archive_servers_file());

/// The server of that name, else the one at that address (archive_server_at()); an empty name is that of the only
/// server. Throws Error naming those that there are.
ArchiveServer find_archive_server(const std::vector<ArchiveServer>& servers, const std::string& name);

}  // namespace simplexseg
