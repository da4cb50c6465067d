// SPDX-License-Identifier: Apache-2.0
// Cache of fetched series on the local disk.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "archive/server.h"
#include "io/platform/locked_folder.h"

namespace simplexseg {

/// Private cache folder (mode 700) with one folder per series and one file UID.dcm per instance. All series in it are
/// complete: a series is received in a temporary folder, which is renamed after the last instance. When the total size
/// then exceeds the limit, the least recently used series are removed. Several processes may share one cache; the next
/// fetch removes temporary folders of processes that were killed.
class ArchiveCache {
 public:
  static constexpr std::uint64_t kDefaultLimit = 20'000'000'000;  ///< default limit, bytes

  /// Creates the folder if it is missing. `limit`: largest total size of all series, bytes. Throws Error when the
  /// folder cannot be created.
  explicit ArchiveCache(std::filesystem::path root = archive_cache_folder(), std::uint64_t limit = kDefaultLimit);

  const std::filesystem::path& root() const { return root_; }
  std::uint64_t limit() const { return limit_; }

  /// Folder of a cached series with exactly these instances, or nullopt. Marks the series as most recently used.
  /// `series`, `instances`: UIDs.
  std::optional<std::filesystem::path> find(const ArchiveServer& server, const std::string& series,
                                            const std::set<std::string>& instances) const;

  /// Total size of all series, bytes.
  std::uint64_t size() const;
  /// Removes the least recently used series, but never `kept_series`, until the total size plus `incoming_bytes` is
  /// within the limit.
  void make_room(std::uint64_t incoming_bytes, const std::filesystem::path& kept_series = {}) const;
  /// Removes all series.
  void clear() const;

  /// Folder of a series after it is complete. Throws Error if `series` is not a UID.
  std::filesystem::path folder_of(const ArchiveServer& server, const std::string& series) const;

  /// Default cache folder of the user: simplexseg/archive in XDG_CACHE_HOME, else in ~/.cache.
  static std::filesystem::path archive_cache_folder();

 private:
  std::filesystem::path root_;
  std::uint64_t limit_;
};

/// Series that is being received into a cache, which must outlive this object. The destructor deletes the series unless
/// commit() succeeded.
class IncomingSeries {
 public:
  /// Creates the temporary folder. `target`: folder of the complete series. Throws Error when that fails.
  IncomingSeries(const ArchiveCache& cache, std::filesystem::path target);
  ~IncomingSeries();
  IncomingSeries(const IncomingSeries&) = delete;
  IncomingSeries& operator=(const IncomingSeries&) = delete;

  /// Temporary folder for the files of the series.
  const std::filesystem::path& folder() const { return folder_.path(); }
  /// Writes the files to the disk, renames the temporary folder to the target and returns the target; replaces an
  /// earlier folder there. Throws Error when that fails.
  std::filesystem::path commit();

 private:
  const ArchiveCache& cache_;
  std::filesystem::path target_;
  LockedFolder folder_;
};

}  // namespace simplexseg
