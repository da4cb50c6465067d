// SPDX-License-Identifier: Apache-2.0
// Common interface to an archive (PACS) for all protocols.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "archive/cache.h"
#include "archive/query.h"
#include "archive/server.h"
#include "remote/web_server.h"

namespace simplexseg {

/// Progress of a transfer.
struct ArchiveTransfer {
  int instances = 0;        ///< number of complete instances
  int total = -1;           ///< total number of instances; below 0 while unknown
  std::uint64_t bytes = 0;  ///< number of bytes transferred, those of incomplete instances included
};

/// Progress callback, called in the caller's thread, at least once a second while a response is awaited. If it returns
/// false, the transfer is cancelled and throws Cancelled (io/platform/load_progress.h).
using ArchiveProgress = std::function<bool(const ArchiveTransfer&)>;

/// Result of sending.
struct ArchiveSent {
  int stored = 0;                     ///< number of instances stored by the archive
  std::vector<std::string> warnings;  ///< distinct warnings of the archive about stored instances, one line each
};

/// Failure of an archive or of the network; the same call may succeed later. Invalid input throws another Error.
using ArchiveFault = RemoteFault;

/// Archive (PACS). Each call opens and closes a separate connection, and no state remains between calls, so different
/// threads may call one object, but not at the same time. All calls throw Error for invalid arguments, Cancelled, and
/// ArchiveFault: one line with the server's name, the cause and a remedy, without secrets or patient data. Causes are a
/// refused connection, an unknown host, an untrusted certificate, a time-out, rejected credentials (401, 403), an
/// object that is not found (404 or an empty response), another status, a response that is damaged, truncated, too
/// large or unexpected, and a full disk.
class Archive {
 public:
  virtual ~Archive() = default;

  /// Checks that the archive responds to this protocol.
  virtual void check(const ArchiveProgress& progress = {}) = 0;
  /// Studies that match a query, the latest first; the list may be empty. Throws Error for an invalid query.
  virtual FoundStudies find_studies(const ArchiveQuery& query, const ArchiveProgress& progress = {}) = 0;
  /// Series of a study, sorted by number. `study`: UID. Throws ArchiveFault if the archive has no series of it.
  virtual std::vector<ArchiveSeries> find_series(const std::string& study, const ArchiveProgress& progress = {}) = 0;
  /// Fetches all instances of a series into the cache, unless they are already there, and returns their folder.
  /// `study`, `series`: UIDs. Throws ArchiveFault and deletes the received files if an instance is missing or damaged.
  virtual std::filesystem::path fetch(const std::string& study, const std::string& series, const ArchiveCache& cache,
                                      const ArchiveProgress& progress = {}) = 0;
  /// Sends DICOM files. Throws Error, before anything is sent, for a file that is not DICOM. Throws ArchiveFault, with
  /// the number of stored files if there are several, if the archive rejects a file or the connection ends. In most
  /// archives, a file that is sent again replaces its earlier copy.
  virtual ArchiveSent send(const std::vector<std::filesystem::path>& files, const ArchiveProgress& progress = {}) = 0;
};

/// Opens an archive without a connection to it. Throws Error for an invalid server (require_archive_server()) or a
/// protocol whose library was missing when this program was built.
std::unique_ptr<Archive> open_archive(const ArchiveServer& server);

}  // namespace simplexseg
