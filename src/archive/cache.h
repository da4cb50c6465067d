// SPDX-License-Identifier: Apache-2.0
// Series that were fetched, on the disk of this machine.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "archive/server.h"
#include "io/held_folder.h"

namespace simplexseg {

/// A folder of series, each a folder of its own with a file UID.dcm for each instance; of the user alone (mode 700).
/// What is in it was whole when it came: an instance is written to a folder beside, and that is renamed when the last
/// one is there. When the series together pass the limit, those go that were used least lately. Several processes may
/// use one cache; what killed ones left half-filled goes at the next fetch.
class ArchiveCache {
 public:
  static constexpr std::uint64_t kUsualLimit = 20'000'000'000;  ///< bytes

  /// Makes the folder where it is missing. Throws Error when it cannot. `limit`: of all series together, in bytes.
  explicit ArchiveCache(std::filesystem::path root = archive_cache_folder(), std::uint64_t limit = kUsualLimit);

  const std::filesystem::path& root() const { return root_; }
  std::uint64_t limit() const { return limit_; }

  /// The folder of a series whose instances are these, which counts as a use of it; none where it is not there or has
  /// others.
  std::optional<std::filesystem::path> find(const ArchiveServer& server, const std::string& series,
                                            const std::set<std::string>& instances) const;

  /// Bytes of all series.
  std::uint64_t size() const;
  /// Removes the series that were used least lately until the rest and `coming` bytes are within the limit; `keep` is
  /// left.
  void make_room(std::uint64_t coming, const std::filesystem::path& keep = {}) const;
  /// Removes all series.
  void clear() const;

  /// Where all files of one series lie when it is whole.
  std::filesystem::path folder_of(const ArchiveServer& server, const std::string& series) const;

  /// The folder of this user for caches: simplexseg/archive in XDG_CACHE_HOME, else in ~/.cache.
  static std::filesystem::path archive_cache_folder();

 private:
  std::filesystem::path root_;
  std::uint64_t limit_;
};

/// A series on its way into a cache. Unless commit() is reached, nothing of it stays.
class IncomingSeries {
 public:
  /// Throws Error when the folder cannot be made.
  IncomingSeries(const ArchiveCache& cache, std::filesystem::path target);
  ~IncomingSeries();
  IncomingSeries(const IncomingSeries&) = delete;
  IncomingSeries& operator=(const IncomingSeries&) = delete;

  /// Where its files are written.
  const std::filesystem::path& folder() const { return folder_.path(); }
  /// Renames it to the target, which is replaced. Throws Error when that fails.
  std::filesystem::path commit();

 private:
  const ArchiveCache& cache_;
  std::filesystem::path target_;
  HeldFolder folder_;
};

}  // namespace simplexseg
