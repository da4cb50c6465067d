// SPDX-License-Identifier: Apache-2.0
#include "archive/cache.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "archive/match.h"
#include "core/error.h"
#include "io/files.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr const char *kIncoming = "incoming-", *kOutgoing = "outgoing-", *kFile = ".dcm";

struct Kept {
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

/// A name that is the same for the same address, and no other's.
std::string key_of(const ArchiveServer& server) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const unsigned char c : address_of(server)) hash = (hash ^ c) * 1099511628211u;
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

std::vector<Kept> all_series(const fs::path& root) {
  std::vector<Kept> all;
  for (const fs::path& server : folders_in(root)) {
    if (is_temporary(server)) continue;
    for (const fs::path& series : folders_in(server)) {
      std::error_code ignored;
      all.push_back({series, bytes_in(series), fs::last_write_time(series, ignored)});
    }
  }
  return all;
}

/// Out of the way at once, so that nobody finds a part of it.
void remove_series(const fs::path& root, const fs::path& folder) {
  std::string gone = (root / (std::string(kOutgoing) + "XXXXXX")).string();
  std::error_code ignored;
  if (!::mkdtemp(gone.data())) return;
  fs::rename(folder, gone, ignored);  // an empty folder is replaced
  fs::remove_all(gone, ignored);
}

void remove_leftovers(const fs::path& root) {
  std::error_code ignored;
  for (const fs::path& folder : folders_in(root)) {
    if (folder.filename().string().starts_with(kOutgoing)) fs::remove_all(folder, ignored);
    if (folder.filename().string().starts_with(kIncoming)) HeldFolder(folder).remove();
  }
}

Error cannot_keep(const fs::path& folder, const std::string& why) {
  return Error("cannot keep series in " + quoted(folder), one_line(why),
               "check the permissions and the space left on the disk");
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
  if (failure) throw cannot_keep(root_, failure.message());
}

fs::path ArchiveCache::folder_of(const ArchiveServer& server, const std::string& series) const {
  require_uid(series, "series");
  return root_ / key_of(server) / series;
}

std::optional<fs::path> ArchiveCache::find(const ArchiveServer& server, const std::string& series,
                                           const std::set<std::string>& instances) const {
  const fs::path folder = folder_of(server, series);
  std::set<std::string> there;
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    there.insert(it->path().filename().string());
  std::set<std::string> wanted;
  for (const std::string& uid : instances) wanted.insert(uid + kFile);
  if (failure || there.empty() || there != wanted) return {};
  fs::last_write_time(folder, fs::file_time_type::clock::now(), failure);
  return folder;
}

std::uint64_t ArchiveCache::size() const {
  std::uint64_t bytes = 0;
  for (const Kept& kept : all_series(root_)) bytes += kept.bytes;
  return bytes;
}

void ArchiveCache::make_room(std::uint64_t coming, const fs::path& keep) const {
  std::vector<Kept> all = all_series(root_);
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
  std::uint64_t bytes = coming;
  for (const Kept& kept : all) bytes += kept.bytes;
  for (const Kept& kept : all) {
    if (bytes <= limit_) return;
    if (kept.folder == keep) continue;
    remove_series(root_, kept.folder);
    bytes -= kept.bytes;
  }
}

void ArchiveCache::clear() const {
  for (const Kept& kept : all_series(root_)) remove_series(root_, kept.folder);
}

IncomingSeries::IncomingSeries(const ArchiveCache& cache, fs::path target) : cache_(cache), target_(std::move(target)) {
  remove_leftovers(cache_.root());
  // A program that starts at this moment may take a folder without a lock for one that was left.
  for (int attempt = 0; attempt < 10 && !folder_.holds(); ++attempt) {
    std::string name = (cache_.root() / (std::string(kIncoming) + "XXXXXX")).string();
    if (!::mkdtemp(name.data())) throw cannot_keep(cache_.root(), std::strerror(errno));
    folder_ = HeldFolder(name);
  }
  if (!folder_.holds()) throw cannot_keep(cache_.root(), "its folder cannot be locked");
}

IncomingSeries::~IncomingSeries() { folder_.remove(); }

fs::path IncomingSeries::commit() {
  // A name before its bytes would be a whole series of empty files after a power cut.
  const int descriptor = ::open(folder_.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool safe = descriptor >= 0 && ::syncfs(descriptor) == 0;
  const std::string why = std::strerror(errno);
  if (descriptor >= 0) ::close(descriptor);
  if (!safe) throw cannot_keep(cache_.root(), why);
  std::error_code failure;
  fs::create_directories(target_.parent_path(), failure);
  if (fs::exists(target_)) remove_series(cache_.root(), target_);
  const fs::path from = folder_.path();
  failure = folder_.release_as(target_);
  if (failure) {
    std::error_code ignored;
    fs::remove_all(from, ignored);
    throw cannot_keep(cache_.root(), failure.message());
  }
  return target_;
}

}  // namespace simplexseg
