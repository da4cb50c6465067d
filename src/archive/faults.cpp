// SPDX-License-Identifier: Apache-2.0
#include "archive/faults.h"

#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"

namespace simplexseg {

ArchiveFault archive_fault(const ArchiveServer& server, const std::string& why, const std::string& what_to_do) {
  return remote_fault(web_server_of(server), why, what_to_do);
}
ArchiveFault connection_refused(const ArchiveServer& server) { return connection_refused(web_server_of(server)); }
ArchiveFault unknown_host(const ArchiveServer& server) { return unknown_host(web_server_of(server)); }
ArchiveFault timed_out(const ArchiveServer& server) { return timed_out(web_server_of(server)); }
ArchiveFault connection_lost(const ArchiveServer& server, const std::string& during) {
  return connection_lost(web_server_of(server), during);
}
ArchiveFault too_large(const ArchiveServer& server, const std::string& what, std::uint64_t limit,
                       const std::string& what_to_do) {
  return too_large(web_server_of(server), what, limit, what_to_do);
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
