// SPDX-License-Identifier: Apache-2.0
// Receives instances from an archive into the cache.
#pragma once
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

#include "archive/archive.h"

namespace simplexseg {

/// File that is written while its bytes arrive. IncomingSeries deletes the file if the series is not completed.
class ReceivedFile {
 public:
  ReceivedFile() = default;
  ~ReceivedFile();
  ReceivedFile(const ReceivedFile&) = delete;
  ReceivedFile& operator=(const ReceivedFile&) = delete;

  /// Creates the file, which must not exist. Throws ArchiveFault.
  void open(const std::filesystem::path& path);
  /// Appends bytes. Throws ArchiveFault, for example when the disk is full.
  void write(const char* data, std::size_t bytes);
  /// Closes the file. Throws ArchiveFault.
  void close();
  bool is_open() const { return descriptor_ >= 0; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Receives the instances of one series. Checks that each instance is readable, belongs to the series, is expected and
/// arrives only once.
class SeriesReceiver {
 public:
  /// Creates the temporary folder. `series`: UID; `expected`: UIDs of all instances of the series, not empty. All
  /// arguments must outlive this object. Throws Error if the folder cannot be created, and Cancelled.
  SeriesReceiver(const ArchiveServer& server, const ArchiveCache& cache, const std::string& series,
                 const std::set<std::string>& expected, const ArchiveProgress& progress);

  /// Path for the file of the next instance.
  std::filesystem::path next_file();
  /// Adds received bytes and reports progress. Throws ArchiveFault when their sum exceeds the limit of the cache, and
  /// Cancelled.
  void count(std::uint64_t bytes);
  /// Reports progress while no data arrives. Throws Cancelled.
  void wait() { count(0); }
  /// Checks a complete file at a path of next_file(), and adds it to the series. Throws ArchiveFault and Cancelled.
  void add(const std::filesystem::path& file);
  /// Moves the series into the cache, removes old series if necessary, and returns the folder. Throws ArchiveFault if
  /// an instance is missing, and the errors of IncomingSeries::commit().
  std::filesystem::path finish();
  const ArchiveTransfer& transfer() const { return transfer_; }

 private:
  const ArchiveServer& server_;
  const ArchiveCache& cache_;
  const std::string& series_;
  const std::set<std::string>& expected_;
  const ArchiveProgress& progress_;
  IncomingSeries incoming_;
  ArchiveTransfer transfer_;
  std::set<std::string> received_;
  int files_ = 0;
};

}  // namespace simplexseg
