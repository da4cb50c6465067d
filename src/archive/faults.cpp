// SPDX-License-Identifier: Apache-2.0
#include "archive/faults.h"

#include "io/files.h"
#include "io/load_progress.h"

namespace simplexseg {

ArchiveFault archive_fault(const ArchiveServer& server, const std::string& why, const std::string& what_to_do) {
  return ArchiveFault("the archive " + one_line(server.name), why, what_to_do);
}

ArchiveFault refused_connection(const ArchiveServer& server) {
  return archive_fault(server, "it refuses the connection at " + address_of(server),
                       "check that it runs, and its host and port");
}
ArchiveFault unknown_host(const ArchiveServer& server) {
  return archive_fault(server, "no host of that name is known: " + address_of(server),
                       "check the name and the network");
}
ArchiveFault timed_out(const ArchiveServer& server) {
  return archive_fault(server, "time-out: nothing came for " + std::to_string(server.timeout_s) + " s",
                       "try again, or give it more time");
}
ArchiveFault ended_early(const ArchiveServer& server, const std::string& during) {
  return archive_fault(server, "the connection ended " + during, "try again");
}
ArchiveFault too_large(const ArchiveServer& server, const std::string& what, std::uint64_t limit) {
  return archive_fault(server, what + " is larger than " + in_words(static_cast<double>(limit)) + " and was cut off",
                       "ask for less");
}
ArchiveFault nothing_there(const ArchiveServer& server, const std::string& what) {
  return archive_fault(server, "it has no " + what, "search again: it may have been removed");
}

void tell(const ArchiveProgress& progress, const ArchiveTransfer& transfer) {
  if (progress && !progress(transfer)) throw CalledOff();
}

}  // namespace simplexseg
