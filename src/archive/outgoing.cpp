// SPDX-License-Identifier: Apache-2.0
#include "archive/outgoing.h"

#include <algorithm>

#include "archive/faults.h"

namespace simplexseg {

Outgoing::Outgoing(const ArchiveServer& server, const std::vector<std::filesystem::path>& files,
                   const ArchiveProgress& progress)
    : progress_(progress) {
  if (files.empty())
    throw Error("the archive " + server.name, "there is no file to send", "name at least one DICOM file");
  for (const std::filesystem::path& file : files) instances_.push_back({file, read_dicom_identity(file)});
  transfer_.total = static_cast<int>(files.size());
  report_progress(progress_, transfer_);
}

void Outgoing::guard(const std::function<void()>& work) const {
  try {
    work();
  } catch (const ArchiveFault& error) {
    if (transfer_.total == 1) throw;
    throw ArchiveFault(std::string(error.what()) + " (" + std::to_string(sent_.stored) + " of " +
                       std::to_string(transfer_.total) + " instances were stored)");
  }
}

void Outgoing::count(std::uint64_t bytes) {
  transfer_.bytes += bytes;
  report_progress(progress_, transfer_);
}

void Outgoing::stored(const std::string& warning) {
  ++sent_.stored;
  if (!warning.empty() && std::find(sent_.warnings.begin(), sent_.warnings.end(), warning) == sent_.warnings.end())
    sent_.warnings.push_back(warning);
  transfer_.instances = sent_.stored;
  report_progress(progress_, transfer_);
}

}  // namespace simplexseg
