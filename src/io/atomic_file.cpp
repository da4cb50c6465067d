// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "io/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kPrefix = ".simplexseg-";

/// ".simplexseg-PROCESS-NUMBER", whatever extension follows.
bool is_temporary_name(std::string_view name) {
  if (!name.starts_with(kPrefix)) return false;
  name.remove_prefix(kPrefix.size());
  for (int number = 0; number < 2; ++number) {
    if (number == 1) {
      if (!name.starts_with('-')) return false;
      name.remove_prefix(1);
    }
    const auto end =
        std::find_if(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) == 0; }) - name.begin();
    if (end == 0) return false;
    name.remove_prefix(static_cast<std::size_t>(end));
  }
  return name.empty() || name.front() == '.';
}

/// The lock tells, rather than the number of the process, which another process may have by now, on this machine or on
/// another that shares the folder. Where the file system has no locks, nothing is removed.
void remove_if_left(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(file.c_str());
  ::close(descriptor);
}

void remove_leftovers(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (is_temporary_name(it->path().filename().native()) && it->is_regular_file(ignored)) remove_if_left(it->path());
  }
}

/// Whether an fsync that failed means that the bytes are not safe, rather than that the file system knows none.
bool means_loss(int reason) { return reason != EINVAL && reason != ENOTSUP && reason != EROFS; }

/// The new name is safe only when the folder is on the disk too.
int sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return 0;  // a folder may be written by those who cannot list it
  const int reason = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  return means_loss(reason) ? reason : 0;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

}  // namespace

AtomicFile::AtomicFile(const fs::path& target) : target_(target) {
  std::error_code error;
  if (fs::is_symlink(target_, error)) {
    const fs::path resolved = fs::weakly_canonical(target_, error);
    if (!error) target_ = resolved;
  }
  const fs::path folder = folder_of(target_);
  if (!fs::is_directory(folder, error)) {
    throw Error("cannot write " + quoted(target), "the folder " + quoted(folder) + " does not exist",
                "create it first");
  }
  const fs::file_status status = fs::status(target_, error);
  if (fs::is_directory(status)) throw Error("cannot write " + quoted(target), "it is a folder", "name a file");
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw Error("cannot write " + quoted(target), "it is a device or a pipe", "name a file");
  remove_leftovers(folder);
  while (!make_temporary(folder)) {
  }
  struct stat old;
  // A file that only its owner could read stays so; where the new owner is another, that is all that can be done.
  if (::stat(target_.c_str(), &old) == 0) static_cast<void>(::fchmod(descriptor_, old.st_mode & 0777));
}

/// False when the name is taken, or another process took the file for a leftover before it was locked.
bool AtomicFile::make_temporary(const fs::path& folder) {
  static std::atomic<unsigned> counter{0};
  std::string name(kPrefix);
  name += std::to_string(::getpid()) + "-" + std::to_string(counter++);
  temporary_ = folder / name;
  descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0 && errno == EEXIST) return false;
  if (descriptor_ < 0) throw failed(std::strerror(errno));
  struct stat made {};
  while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
  }
  if (::fstat(descriptor_, &made) == 0 && made.st_nlink > 0) return true;
  ::close(descriptor_);
  descriptor_ = -1;
  return false;
}

AtomicFile::~AtomicFile() {
  if (!committed_ && descriptor_ >= 0) ::unlink(temporary_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
}

void AtomicFile::write(const void* data, std::size_t bytes) {
  const auto* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t done = ::write(descriptor_, from, std::min<std::size_t>(bytes, 1u << 30));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) throw failed(std::strerror(done < 0 ? errno : ENOSPC));
    from += done;
    bytes -= static_cast<std::size_t>(done);
  }
}

void AtomicFile::write_at(std::uint64_t offset, const void* data, std::size_t bytes) {
  const off_t end = ::lseek(descriptor_, 0, SEEK_CUR);
  if (end < 0 || ::lseek(descriptor_, static_cast<off_t>(offset), SEEK_SET) < 0) throw failed(std::strerror(errno));
  write(data, bytes);
  if (::lseek(descriptor_, end, SEEK_SET) < 0) throw failed(std::strerror(errno));
}

void AtomicFile::commit() {
  // Renaming a file whose bytes are still in flight could leave an empty one after a power cut.
  if (::fsync(descriptor_) != 0 && means_loss(errno)) throw failed(std::strerror(errno));
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) throw failed(std::strerror(errno));
  committed_ = true;
  if (const int reason = sync_folder(folder_of(target_))) throw failed(std::strerror(reason));
}

Error AtomicFile::failed(const std::string& why) const {
  return Error("cannot write " + quoted(target_), one_line(why),
               "check the permissions and the space left on the disk");
}

void write_bytes(AtomicFile& file, const std::string& bytes) { file.write(bytes.data(), bytes.size()); }

}  // namespace simplexseg
