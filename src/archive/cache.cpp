// SPDX-License-Identifier: Apache-2.0
#include "archive/cache.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <vector>

#include "archive/match.h"
#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr const char *kIncoming = "incoming-", *kOutgoing = "outgoing-", *kFile = ".dcm";

struct CachedSeries {
  fs::path folder;
  std::uint64_t bytes = 0;
  fs::file_time_type used;
};

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    std::error_code ignored;
    const std::uintmax_t size = it->file_size(ignored);
    if (!ignored) bytes += size;
  }
  return bytes;
}

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure)) {
    std::error_code ignored;
    if (it->is_directory(ignored) && !it->is_symlink(ignored)) folders.push_back(it->path());
  }
  return folders;
}

bool is_temporary(const fs::path& folder) {
  const std::string name = folder.filename().string();
  return name.starts_with(kIncoming) || name.starts_with(kOutgoing);
}

/// Folder name of a server: hash of the server's address.
std::string key_of(const ArchiveServer& server) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const unsigned char c : address_of(server)) hash = (hash ^ c) * 1099511628211u;
  return hexadecimal_text(hash, 16);
}

std::vector<CachedSeries> all_series(const fs::path& root) {
  std::vector<CachedSeries> all;
  for (const fs::path& server : folders_in(root)) {
    if (is_temporary(server)) continue;
    for (const fs::path& series : folders_in(server)) {
      std::error_code ignored;
      all.push_back({series, bytes_in(series), fs::last_write_time(series, ignored)});
    }
  }
  return all;
}

/// Deletes a series; renames its folder first, so that no process finds an incomplete series.
void remove_series(const fs::path& root, const fs::path& folder) {
  std::string outgoing = (root / (std::string(kOutgoing) + "XXXXXX")).string();
  std::error_code ignored;
  if (!::mkdtemp(outgoing.data())) return;
  fs::rename(folder, outgoing, ignored);  // replaces the empty folder
  fs::remove_all(outgoing, ignored);
}

void remove_leftovers(const fs::path& root) {
  std::error_code ignored;
  for (const fs::path& folder : folders_in(root)) {
    if (folder.filename().string().starts_with(kOutgoing)) fs::remove_all(folder, ignored);
    if (folder.filename().string().starts_with(kIncoming)) LockedFolder(folder).remove();
  }
}

Error cannot_store(const fs::path& folder, int reason) {
  return write_error("cannot store series in " + quoted(folder), folder, reason);
}

}  // namespace

fs::path ArchiveCache::archive_cache_folder() {
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  const char* const home = std::getenv("HOME");
  const fs::path folder = cache && *cache == '/' ? fs::path(cache) : fs::path(home ? home : "/") / ".cache";
  return folder / "simplexseg" / "archive";
}

ArchiveCache::ArchiveCache(fs::path root, std::uint64_t limit) : root_(std::move(root)), limit_(limit) {
  std::error_code failure;
  fs::create_directories(root_, failure);
  if (!failure) fs::permissions(root_, fs::perms::owner_all, failure);
  if (failure) throw cannot_store(root_, failure.value());
}

fs::path ArchiveCache::folder_of(const ArchiveServer& server, const std::string& series) const {
  require_uid(series, "series");
  return root_ / key_of(server) / series;
}

std::optional<fs::path> ArchiveCache::find(const ArchiveServer& server, const std::string& series,
                                           const std::set<std::string>& instances) const {
  const fs::path folder = folder_of(server, series);
  std::set<std::string> present;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    present.insert(it->path().filename().string());
  std::set<std::string> expected;
  for (const std::string& uid : instances) expected.insert(uid + kFile);
  if (failure || present.empty() || present != expected) return {};
  fs::last_write_time(folder, fs::file_time_type::clock::now(), failure);
  return folder;
}

std::uint64_t ArchiveCache::size() const {
  std::uint64_t bytes = 0;
  for (const CachedSeries& cached : all_series(root_)) bytes += cached.bytes;
  return bytes;
}

void ArchiveCache::make_room(std::uint64_t incoming_bytes, const fs::path& kept_series) const {
  std::vector<CachedSeries> all = all_series(root_);
  std::sort(all.begin(), all.end(), [](const CachedSeries& a, const CachedSeries& b) { return a.used < b.used; });
  std::uint64_t bytes = incoming_bytes;
  for (const CachedSeries& cached : all) bytes += cached.bytes;
  for (const CachedSeries& cached : all) {
    if (bytes <= limit_) return;
    if (cached.folder == kept_series) continue;
    remove_series(root_, cached.folder);
    bytes -= cached.bytes;
  }
}

void ArchiveCache::clear() const {
  for (const CachedSeries& cached : all_series(root_)) remove_series(root_, cached.folder);
}

IncomingSeries::IncomingSeries(const ArchiveCache& cache, fs::path target) : cache_(cache), target_(std::move(target)) {
  remove_leftovers(cache_.root());
  // Another process may remove the new folder before it is locked.
  for (int attempt = 0; attempt < 10 && !folder_.is_locked(); ++attempt) {
    std::string name = (cache_.root() / (std::string(kIncoming) + "XXXXXX")).string();
    if (!::mkdtemp(name.data())) throw cannot_store(cache_.root(), errno);
    folder_ = LockedFolder(name);
  }
  if (!folder_.is_locked())
    throw Error("cannot store series in " + quoted(cache_.root()), "its folder cannot be locked", "try again");
}

IncomingSeries::~IncomingSeries() { folder_.remove(); }

fs::path IncomingSeries::commit() {
  // Writes the files to the disk: a power failure could otherwise leave a renamed series with empty files.
  const int descriptor = ::open(folder_.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool safe = descriptor >= 0 && ::syncfs(descriptor) == 0;
  const int reason = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!safe) throw cannot_store(cache_.root(), reason);
  std::error_code failure;
  fs::create_directories(target_.parent_path(), failure);
  if (fs::exists(target_)) remove_series(cache_.root(), target_);
  const fs::path from = folder_.path();
  failure = folder_.release_as(target_);
  if (failure) {
    std::error_code ignored;
    fs::remove_all(from, ignored);
    throw cannot_store(cache_.root(), failure.value());
  }
  return target_;
}

}  // namespace simplexseg
