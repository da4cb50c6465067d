// SPDX-License-Identifier: Apache-2.0
// Error messages about archive servers (PACS), and helpers for both protocols.
#pragma once
#include <string>

#include "archive/archive.h"
#include "core/error.h"

namespace simplexseg {

inline constexpr const char* kAskAdministrator = "ask your PACS administrator";
inline constexpr const char* kNarrowSearch = "narrow the search";

/// Returns a fault with the name of the server, the cause `why` and the remedy `what_to_do`.
ArchiveFault archive_fault(const ArchiveServer& server, const std::string& why, const std::string& what_to_do);

// Faults common to both protocols. `during`: phase in which the connection was lost, for example "during sending";
// `what`: name of the object that is too large or was not found; `limit`: largest size, bytes.
ArchiveFault connection_refused(const ArchiveServer& server);
ArchiveFault unknown_host(const ArchiveServer& server);
ArchiveFault timed_out(const ArchiveServer& server);
ArchiveFault connection_lost(const ArchiveServer& server, const std::string& during);
ArchiveFault too_large(const ArchiveServer& server, const std::string& what, std::uint64_t limit,
                       const std::string& what_to_do);
ArchiveFault not_found(const ArchiveServer& server, const std::string& what);

/// Returns the count that an attribute contains as text, or `otherwise` if the text is no integer from 0 to 999999999.
int count_in(const std::string& text, int otherwise);
/// Returns a status code with four hexadecimal digits, as in PS3.7: "A700".
std::string status_text(unsigned status);

/// Calls the progress callback, if there is one. Throws Cancelled when it returns false.
void report_progress(const ArchiveProgress& progress, const ArchiveTransfer& transfer);

}  // namespace simplexseg
