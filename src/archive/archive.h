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
#include "core/error.h"

namespace simplexseg {

/// Progress of a transfer.
struct ArchiveTransfer {
  int instances = 0;        ///< complete instances
  int total = -1;           ///< total number of instances; below 0 while unknown
  std::uint64_t bytes = 0;  ///< bytes transferred, incomplete instances included
};

/// Callback in the caller's thread, at least once a second while a response is awaited. Returning false cancels the
/// transfer, which then throws Cancelled (io/platform/load_progress.h).
using ArchiveProgress = std::function<bool(const ArchiveTransfer&)>;

/// Result of sending.
struct ArchiveSent {
  int stored = 0;                     ///< instances stored by the archive
  std::vector<std::string> warnings;  ///< one line each: stored with changes
};

/// Failure of an archive or of the network, which may succeed later. Bad input is an Error as elsewhere.
class ArchiveFault : public Error {
 public:
  using Error::Error;
};

/// Archive (PACS). Each call opens and closes its own connection and stores no state, so several threads may use one
/// object, one at a time. All calls throw ArchiveFault, one line with the server's name, the cause and a remedy, but
/// without secrets or patient data. Causes: refused connection, unknown host, certificate, time-out, credentials (401,
/// 403), not found (404 or an empty response), another status, a response that is damaged, truncated, too large or
/// unexpected, a full disk.
class Archive {
 public:
  virtual ~Archive() = default;

  /// Checks that the archive responds.
  virtual void check(const ArchiveProgress& progress = {}) = 0;
  /// Studies that match a query; the list may be empty.
  virtual FoundStudies find_studies(const ArchiveQuery& query, const ArchiveProgress& progress = {}) = 0;
  /// Series of a study, sorted by number. Throws ArchiveFault where there is none.
  virtual std::vector<ArchiveSeries> find_series(const std::string& study, const ArchiveProgress& progress = {}) = 0;
  /// Fetches all instances of a series into the cache, unless they are already there, and returns the folder. Throws
  /// ArchiveFault and deletes the received files when an instance is missing or damaged.
  virtual std::filesystem::path fetch(const std::string& study, const std::string& series, const ArchiveCache& cache,
                                      const ArchiveProgress& progress = {}) = 0;
  /// Sends DICOM files. Throws Error, before anything is sent, for a file that is not DICOM. Throws ArchiveFault, with
  /// the number of stored files, when the archive rejects one or the connection ends. A file that is sent again
  /// replaces its earlier copy.
  virtual ArchiveSent send(const std::vector<std::filesystem::path>& files, const ArchiveProgress& progress = {}) = 0;
};

/// Opens an archive. Throws Error for an invalid server (require_archive_server()) or a protocol that this program was
/// built without.
std::unique_ptr<Archive> open_archive(const ArchiveServer& server);

}  // namespace simplexseg
