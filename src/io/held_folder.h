// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <system_error>

namespace simplexseg {

/// A folder that is held as long as this object lives, or the process, however that ends: a lock on a file in it.
class HeldFolder {
 public:
  HeldFolder() = default;
  /// Takes the folder, which must exist; holds() is false when another process, or this one, has it.
  explicit HeldFolder(std::filesystem::path folder);
  ~HeldFolder();
  HeldFolder(HeldFolder&& other) noexcept;
  HeldFolder& operator=(HeldFolder&& other) noexcept;
  HeldFolder(const HeldFolder&) = delete;
  HeldFolder& operator=(const HeldFolder&) = delete;

  bool holds() const { return descriptor_ >= 0; }
  const std::filesystem::path& path() const { return path_; }
  /// Removes it with all that is in it, and lets it go.
  void remove();
  /// Renames it, without its lock, and lets it go; where that fails it is held no more but stays.
  std::error_code release_as(const std::filesystem::path& target);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace simplexseg
