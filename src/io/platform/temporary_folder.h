// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace simplexseg {

/// Temporary folder below TMPDIR, deleted with its contents by the destructor. The constructor throws Error when it
/// cannot be created.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace simplexseg
