// SPDX-License-Identifier: Apache-2.0
// Instances that come from a network, on their way into the cache.
#pragma once
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

#include "archive/archive.h"

namespace simplexseg {

/// A file that is written as its bytes come; what there is of it goes with IncomingSeries where it is not wanted.
class ReceivedFile {
 public:
  ReceivedFile() = default;
  ~ReceivedFile();
  ReceivedFile(const ReceivedFile&) = delete;
  ReceivedFile& operator=(const ReceivedFile&) = delete;

  /// Makes the file, which must not be there. Throws Error.
  void open(const std::filesystem::path& path);
  /// Throws Error (full disk).
  void write(const char* data, std::size_t bytes);
  /// Throws Error.
  void close();
  bool is_open() const { return descriptor_ >= 0; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Takes the instances of one series, each checked when it has come: it is whole, of that series, expected, and came
/// once.
class SeriesReceiver {
 public:
  /// `expected`: UIDs of all its instances, not none. What is passed must live as long as this.
  SeriesReceiver(const ArchiveServer& server, const ArchiveCache& cache, const std::string& series,
                 const std::set<std::string>& expected, const ArchiveProgress& progress);

  /// A name for the next instance's file.
  std::filesystem::path next_file();
  /// Bytes that came over the network. Throws Error where they are more than the cache holds, and CalledOff.
  void count(std::uint64_t bytes);
  /// The same without bytes, while nothing comes.
  void wait() { count(0); }
  /// A file of next_file() that is written. Throws Error.
  void take(const std::filesystem::path& file);
  /// Puts the series into the cache. Throws Error where an instance is missing.
  std::filesystem::path finish();
  const ArchiveTransfer& transfer() const { return transfer_; }

 private:
  const ArchiveServer& server_;
  const ArchiveCache& cache_;
  const std::string& series_;
  const std::set<std::string>& expected_;
  const ArchiveProgress& progress_;
  IncomingSeries incoming_;
  ArchiveTransfer transfer_;
  std::set<std::string> taken_;
  int files_ = 0;
};

}  // namespace simplexseg
