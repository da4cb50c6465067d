// SPDX-License-Identifier: Apache-2.0
#include "io/platform/locked_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <utility>

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr const char* kLock = "lock";

}  // namespace

LockedFolder::LockedFolder(fs::path folder) : path_(std::move(folder)) {
  descriptor_ = ::open((path_ / kLock).c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) ::close(std::exchange(descriptor_, -1));
}

LockedFolder::~LockedFolder() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

LockedFolder::LockedFolder(LockedFolder&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

LockedFolder& LockedFolder::operator=(LockedFolder&& other) noexcept {
  std::swap(path_, other.path_), std::swap(descriptor_, other.descriptor_);
  return *this;
}

void LockedFolder::remove() {
  if (!is_locked()) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(std::exchange(descriptor_, -1));
}

std::error_code LockedFolder::release_as(const fs::path& target) {
  std::error_code failure;
  fs::remove(path_ / kLock, failure);
  if (!failure) fs::rename(path_, target, failure);
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  return failure;
}

}  // namespace simplexseg
