// SPDX-License-Identifier: Apache-2.0
#include "archive/archive.h"

#include "archive/implementations.h"
#include "core/error.h"

namespace simplexseg {

std::unique_ptr<Archive> open_archive(const ArchiveServer& server) {
  require_archive_server(server);
  const bool web = server.protocol == ArchiveProtocol::DicomWeb;
#ifdef SIMPLEXSEG_HAS_CURL
  if (web) return open_dicom_web(server);
#endif
#ifdef SIMPLEXSEG_HAS_DCMTK
  if (!web) return open_dimse(server);
#endif
  throw Error(
      "the archive " + server.name, std::string("this program was built without ") + (web ? "libcurl" : "DCMTK"),
      "install that library and build again, or use an archive with " + std::string(web ? "DIMSE" : "DICOMweb"));
}

}  // namespace simplexseg
