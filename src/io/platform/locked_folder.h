// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <system_error>

namespace simplexseg {

/// Folder that this process has locked by a lock file in it. The lock ends with this object or with the process, also
/// after a crash.
class LockedFolder {
 public:
  LockedFolder() = default;
  /// Locks the folder, which must exist. is_locked() is false when this or another process has already locked the
  /// folder, or when the lock file cannot be created.
  explicit LockedFolder(std::filesystem::path folder);
  ~LockedFolder();
  LockedFolder(LockedFolder&& other) noexcept;
  LockedFolder& operator=(LockedFolder&& other) noexcept;
  LockedFolder(const LockedFolder&) = delete;
  LockedFolder& operator=(const LockedFolder&) = delete;

  bool is_locked() const { return descriptor_ >= 0; }
  const std::filesystem::path& path() const { return path_; }
  /// Deletes the folder with its contents and releases the lock. Does nothing when the folder is not locked.
  void remove();
  /// Deletes the lock file, renames the folder to `target` and releases the lock. On failure returns the error; the
  /// folder then keeps its path and is no longer locked.
  std::error_code release_as(const std::filesystem::path& target);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace simplexseg
