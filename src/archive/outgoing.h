// SPDX-License-Identifier: Apache-2.0
// Instances on their way to an archive.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "archive/archive.h"
#include "io/dicom_identity.h"

namespace simplexseg {

/// Files that are to be sent, and how far that is. What is passed must live as long as this.
class Outgoing {
 public:
  struct Instance {
    std::filesystem::path file;
    DicomIdentity identity;
  };
  /// Reads all of them. Throws Error where one is no file of DICOM, or there is none.
  Outgoing(const ArchiveServer& server, const std::vector<std::filesystem::path>& files,
           const ArchiveProgress& progress);

  const std::vector<Instance>& instances() const { return instances_; }
  /// Sends something: the Error of a failure says how many instances had been stored by then.
  void guard(const std::function<void()>& work) const;
  /// Throws CalledOff.
  void count(std::uint64_t bytes);
  /// One instance more. `warning`: what the archive says of it, or empty.
  void stored(const std::string& warning);
  ArchiveSent sent() const { return sent_; }

 private:
  const ArchiveProgress& progress_;
  std::vector<Instance> instances_;
  ArchiveTransfer transfer_;
  ArchiveSent sent_;
};

}  // namespace simplexseg
