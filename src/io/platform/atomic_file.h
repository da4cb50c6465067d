// SPDX-License-Identifier: Apache-2.0
// Atomic writing of files, for every file that the program saves.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/error.h"

namespace simplexseg {

/// Temporary file in the folder of its target. commit() renames it to the target once all bytes are on the disk.
/// Without commit(), the destructor deletes it and the target stays unchanged. The constructor also deletes temporary
/// files that killed processes left in the folder, but not those that another process has locked for writing.
class AtomicFile {
 public:
  /// Creates the temporary file. If `target` is a symbolic link, the file to which the link points is replaced. The
  /// permissions of an existing file are retained. Throws Error when the folder of `target` does not exist or is not
  /// writable, or when `target` exists but is not a regular file.
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends bytes. Throws Error when the disk is full or the file exceeds the size limit.
  void write(const void* data, std::size_t bytes);
  /// Overwrites bytes that were already written, starting `offset` bytes after the beginning of the file. Throws Error
  /// like write().
  void write_at(std::uint64_t offset, const void* data, std::size_t bytes);
  /// Flushes the file to the disk, renames it to the target and flushes the folder. Throws Error when a step fails; the
  /// target is already replaced if only the last step fails.
  void commit();
  /// Returns the Error for a failed write, with the cause `why` and the remedy `what_to_do`.
  Error failed(const std::string& why, const std::string& what_to_do = "save it under another name or format") const;

 private:
  Error error_for(int reason) const;
  bool make_temporary(const std::filesystem::path& folder);

  std::filesystem::path target_, temporary_;
  int descriptor_ = -1;
  bool committed_ = false;
};

/// Appends `bytes` to the file. Throws Error when they cannot be written.
void write_bytes(AtomicFile& file, const std::string& bytes);

}  // namespace simplexseg
