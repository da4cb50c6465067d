// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace simplexseg {

/// A folder of its own among the temporary files (TMPDIR), which is removed with all that is in it. Throws Error when
/// there can be none.
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
