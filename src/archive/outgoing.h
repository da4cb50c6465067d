// SPDX-License-Identifier: Apache-2.0
// Instances that are sent to an archive.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "archive/archive.h"
#include "io/dicom/dicom_identity.h"

namespace simplexseg {

/// Files to send and the progress of sending. `progress` must outlive this object.
class Outgoing {
 public:
  struct Instance {
    std::filesystem::path file;
    DicomIdentity identity;
  };
  /// Reads the UIDs of all files. Throws Error for a file that is not DICOM, or if there is no file.
  Outgoing(const ArchiveServer& server, const std::vector<std::filesystem::path>& files,
           const ArchiveProgress& progress);

  const std::vector<Instance>& instances() const { return instances_; }
  /// Calls `work`. If several files are sent, adds the number of stored instances to the text of an ArchiveFault.
  void guard(const std::function<void()>& work) const;
  /// Adds sent bytes and reports progress. Throws Cancelled.
  void count(std::uint64_t bytes);
  /// Counts a stored instance and reports progress. `warning`: warning of the archive, or empty. Throws Cancelled.
  void stored(const std::string& warning);
  ArchiveSent sent() const { return sent_; }

 private:
  const ArchiveProgress& progress_;
  std::vector<Instance> instances_;
  ArchiveTransfer transfer_;
  ArchiveSent sent_;
};

}  // namespace simplexseg
