// SPDX-License-Identifier: Apache-2.0
#include "io/platform/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <string_view>

#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kTemporaryPrefix = ".simplexseg-";

/// Returns true for ".simplexseg-PID-COUNTER", with or without an extension.
bool is_temporary_name(std::string_view name) {
  if (!name.starts_with(kTemporaryPrefix)) return false;
  name.remove_prefix(kTemporaryPrefix.size());
  for (int number = 0; number < 2; ++number) {
    if (number == 1) {
      if (!name.starts_with('-')) return false;
      name.remove_prefix(1);
    }
    const auto end = std::find_if_not(name.begin(), name.end(), is_ascii_digit) - name.begin();
    if (end == 0) return false;
    name.remove_prefix(static_cast<std::size_t>(end));
  }
  return name.empty() || name.front() == '.';
}

/// Deletes a temporary file that no process has locked. The process ID (PID) in the name does not identify a running
/// owner: the system may have reused the ID, or it may belong to another machine that shares the folder. On file
/// systems without locks nothing is deleted.
void remove_if_unlocked(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(file.c_str());
  ::close(descriptor);
}

void remove_leftovers(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (is_temporary_name(it->path().filename().native()) && it->is_regular_file(ignored))
      remove_if_unlocked(it->path());
  }
}

/// Returns false for errors of fsync() that only mean that the file system does not support fsync().
bool is_data_loss(int reason) { return reason != EINVAL && reason != ENOTSUP && reason != EROFS; }

/// Flushes the folder, because a renamed file is safe only once its folder is on the disk. Returns an errno value, or
/// 0.
int sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return 0;  // a folder can be writable but not readable
  const int reason = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  return is_data_loss(reason) ? reason : 0;
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
                "create the folder first");
  }
  const fs::file_status status = fs::status(target_, error);
  if (fs::is_directory(status)) throw Error("cannot write " + quoted(target), "it is a folder", "choose a file name");
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw Error("cannot write " + quoted(target), "it is a device or a pipe", "choose a regular file");
  remove_leftovers(folder);
  while (!make_temporary(folder)) {
  }
  struct stat old;
  // Keeps the permissions of the old file. Its owner cannot be kept.
  if (::stat(target_.c_str(), &old) == 0) static_cast<void>(::fchmod(descriptor_, old.st_mode & 0777));
}

/// Creates and locks the temporary file. Returns false when the name is in use, or when another process deleted the
/// file before it was locked.
bool AtomicFile::make_temporary(const fs::path& folder) {
  static std::atomic<unsigned> counter{0};
  std::string name(kTemporaryPrefix);
  name += std::to_string(::getpid()) + "-" + std::to_string(counter++);
  temporary_ = folder / name;
  descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0 && errno == EEXIST) return false;
  if (descriptor_ < 0) throw error_for(errno);
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
    if (done <= 0) throw error_for(done < 0 ? errno : ENOSPC);
    from += done;
    bytes -= static_cast<std::size_t>(done);
  }
}

void AtomicFile::write_at(std::uint64_t offset, const void* data, std::size_t bytes) {
  const off_t end = ::lseek(descriptor_, 0, SEEK_CUR);
  if (end < 0 || ::lseek(descriptor_, static_cast<off_t>(offset), SEEK_SET) < 0) throw error_for(errno);
  write(data, bytes);
  if (::lseek(descriptor_, end, SEEK_SET) < 0) throw error_for(errno);
}

void AtomicFile::commit() {
  // Without fsync() a power failure after the rename could leave an empty file.
  if (::fsync(descriptor_) != 0 && is_data_loss(errno)) throw error_for(errno);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) throw error_for(errno);
  committed_ = true;
  if (const int reason = sync_folder(folder_of(target_))) throw error_for(reason);
}

Error AtomicFile::failed(const std::string& why, const std::string& what_to_do) const {
  return Error("cannot write " + quoted(target_), one_line(why), what_to_do);
}

/// Returns the Error for an errno value.
Error AtomicFile::error_for(int reason) const {
  return write_error("cannot write " + quoted(target_), folder_of(target_), reason);
}

void write_bytes(AtomicFile& file, const std::string& bytes) { file.write(bytes.data(), bytes.size()); }

}  // namespace simplexseg
