// SPDX-License-Identifier: Apache-2.0
// The one way in which files are written.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/error.h"

namespace simplexseg {

/// A file written beside its target and renamed when it is whole and on the disk. Where commit() is not reached it is
/// taken away again and the target stays as it was. What programs that were killed left behind in the folder is removed
/// when the next file is made there; files that are still being written, by whatever process, hold a lock and stay.
class AtomicFile {
 public:
  /// Makes the file. A link is kept, and what it names is replaced; an old file's permissions are kept. Throws Error
  /// when the folder of `target` does not exist or cannot be written, or `target` is no regular file.
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends bytes. Throws Error (full disk, limit on the size of files).
  void write(const void* data, std::size_t bytes);
  /// Replaces bytes that were written before, from `offset` on. Throws Error as write().
  void write_at(std::uint64_t offset, const void* data, std::size_t bytes);
  /// Brings the file to the disk and renames it. Throws Error when either fails.
  void commit();
  /// The Error for a write that failed: `why` in the system's words.
  Error failed(const std::string& why) const;

 private:
  bool make_temporary(const std::filesystem::path& folder);

  std::filesystem::path target_, temporary_;
  int descriptor_ = -1;
  bool committed_ = false;
};

/// Appends the bytes of a text. Throws Error when they cannot be written.
void write_bytes(AtomicFile& file, const std::string& bytes);

}  // namespace simplexseg
