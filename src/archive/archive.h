// SPDX-License-Identifier: Apache-2.0
// The one interface to an archive (PACS), whatever it speaks.
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

/// How far a transfer is.
struct ArchiveTransfer {
  int instances = 0;        ///< whole ones
  int of = -1;              ///< below 0 while unknown
  std::uint64_t bytes = 0;  ///< that went over the network, begun instances included
};

/// Called in the thread that called, at least once a second while an answer is waited for. False calls the work off,
/// which then throws CalledOff (io/load_progress.h).
using ArchiveProgress = std::function<bool(const ArchiveTransfer&)>;

/// What came of sending.
struct ArchiveSent {
  int stored = 0;                     ///< instances that the archive took
  std::vector<std::string> warnings;  ///< one line each: taken, with changes
};

/// A fault of an archive or of what lies between: it may go well another time. Bad input is an Error as elsewhere.
class ArchiveFault : public Error {
 public:
  using Error::Error;
};

/// An archive. Each call opens its connection and closes it. All throw ArchiveFault: one line with the server's
/// name, the cause and a remedy, and neither a secret nor anything of a patient. The cause is one of: refused
/// connection, unknown host, certificate, time-out, credentials (401, 403), nothing there (404, empty answer), another
/// status, an answer that is damaged, cut short, too large or not what was asked for, a disk that is full. Nothing is
/// kept between calls, so that one object may be used by one thread after another.
class Archive {
 public:
  virtual ~Archive() = default;

  /// Asks for nothing, to see whether the archive answers.
  virtual void check(const ArchiveProgress& progress = {}) = 0;
  /// No study is no fault here: the list is empty.
  virtual FoundStudies find_studies(const ArchiveQuery& query, const ArchiveProgress& progress = {}) = 0;
  /// By number. It is a fault where the study has none.
  virtual std::vector<ArchiveSeries> find_series(const std::string& study, const ArchiveProgress& progress = {}) = 0;
  /// Fetches a series with all its instances into the cache, unless it is there, and gives its folder. It is a
  /// fault too when an instance is missing or damaged: then nothing of it stays.
  virtual std::filesystem::path fetch(const std::string& study, const std::string& series, const ArchiveCache& cache,
                                      const ArchiveProgress& progress = {}) = 0;
  /// Sends files of DICOM. Throws Error, before anything is sent, where one is none. It is a fault where the archive
  /// refuses one or the connection ends, and says how many it has taken. Sent again, they replace themselves.
  virtual ArchiveSent send(const std::vector<std::filesystem::path>& files, const ArchiveProgress& progress = {}) = 0;
};

/// Throws Error where the server is refused (require_archive_server()), or this program was built without what it
/// speaks.
std::unique_ptr<Archive> open_archive(const ArchiveServer& server);

}  // namespace simplexseg
