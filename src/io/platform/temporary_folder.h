// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace simplexseg {

/// New folder for temporary files, in the folder that the environment variable TMPDIR names (default: /tmp). The
/// destructor deletes the folder with its contents; the constructor throws Error when the folder cannot be created.
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
