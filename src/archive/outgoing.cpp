// SPDX-License-Identifier: Apache-2.0
#include "archive/outgoing.h"

#include <algorithm>

#include "archive/faults.h"

namespace simplexseg {

Outgoing::Outgoing(const ArchiveServer& server, const std::vector<std::filesystem::path>& files,
                   const ArchiveProgress& progress)
    : progress_(progress) {
  if (files.empty()) throw Error("the archive " + server.name, "nothing is to be sent to it", "name a file of DICOM");
  for (const std::filesystem::path& file : files) instances_.push_back({file, read_dicom_identity(file)});
  transfer_.of = static_cast<int>(files.size());
  tell(progress_, transfer_);
}

void Outgoing::guard(const std::function<void()>& work) const {
  try {
    work();
  } catch (const ArchiveFault& error) {
    if (transfer_.of == 1) throw;
    throw ArchiveFault(std::string(error.what()) + " (of " + std::to_string(transfer_.of) + " instances it had taken " +
                       std::to_string(sent_.stored) + ")");
  }
}

void Outgoing::count(std::uint64_t bytes) {
  transfer_.bytes += bytes;
  tell(progress_, transfer_);
}

void Outgoing::stored(const std::string& warning) {
  ++sent_.stored;
  if (!warning.empty() && std::find(sent_.warnings.begin(), sent_.warnings.end(), warning) == sent_.warnings.end())
    sent_.warnings.push_back(warning);
  transfer_.instances = sent_.stored;
  tell(progress_, transfer_);
}

}  // namespace simplexseg
