// SPDX-License-Identifier: Apache-2.0
#include "archive/faults.h"

#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"

namespace simplexseg {

ArchiveFault archive_fault(const ArchiveServer& server, const std::string& why, const std::string& what_to_do) {
  return ArchiveFault("the archive " + one_line(server.name), why, what_to_do);
}

ArchiveFault connection_refused(const ArchiveServer& server) {
  return archive_fault(server, "it refused the connection at " + address_of(server),
                       "check its host and port, and that it is running");
}
ArchiveFault unknown_host(const ArchiveServer& server) {
  return archive_fault(server, "the host is unknown: " + address_of(server), "check the name and the network");
}
ArchiveFault timed_out(const ArchiveServer& server) {
  return archive_fault(server, "time-out: no data for " + std::to_string(server.timeout_s) + " s",
                       "try again, or set a longer time-out");
}
ArchiveFault connection_lost(const ArchiveServer& server, const std::string& during) {
  return archive_fault(server, "the connection ended " + during, "try again");
}
ArchiveFault too_large(const ArchiveServer& server, const std::string& what, std::uint64_t limit,
                       const std::string& what_to_do) {
  return archive_fault(
      server, what + " is larger than " + format_bytes(static_cast<double>(limit)) + " and was cancelled", what_to_do);
}
ArchiveFault not_found(const ArchiveServer& server, const std::string& what) {
  return archive_fault(server, "it has no " + what, "search again; it may have been removed");
}

int count_in(const std::string& text, int otherwise) {
  const std::optional<std::int64_t> number = parse_integer(text);
  return number && *number >= 0 && *number < 1'000'000'000 ? static_cast<int>(*number) : otherwise;
}

std::string status_text(unsigned status) {
  std::string text = hexadecimal_text(status, 4);
  for (char& c : text) c = c >= 'a' ? static_cast<char>(c - 'a' + 'A') : c;
  return text;
}

void report_progress(const ArchiveProgress& progress, const ArchiveTransfer& transfer) {
  if (progress && !progress(transfer)) throw Cancelled();
}

}  // namespace simplexseg
