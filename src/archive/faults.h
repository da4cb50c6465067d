// SPDX-License-Identifier: Apache-2.0
// How an archive's faults are told.
#pragma once
#include <string>

#include "archive/archive.h"
#include "core/error.h"

namespace simplexseg {

/// "the archive NAME: why; what to do".
ArchiveFault archive_fault(const ArchiveServer& server, const std::string& why, const std::string& what_to_do);

// Those that both protocols have, each in one wording.
ArchiveFault refused_connection(const ArchiveServer& server);
ArchiveFault unknown_host(const ArchiveServer& server);
ArchiveFault timed_out(const ArchiveServer& server);
ArchiveFault ended_early(const ArchiveServer& server, const std::string& during);
ArchiveFault too_large(const ArchiveServer& server, const std::string& what, std::uint64_t limit);
ArchiveFault nothing_there(const ArchiveServer& server, const std::string& what);

/// Tells the progress, where somebody listens. Throws CalledOff.
void tell(const ArchiveProgress& progress, const ArchiveTransfer& transfer);

}  // namespace simplexseg
