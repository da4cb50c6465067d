// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_identity.h"

#include "core/error.h"
#include "io/dicom/dicom_requests.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_validation.h"
#include "io/platform/files.h"

namespace simplexseg {

DicomIdentity read_dicom_identity(const std::filesystem::path& path) {
  const std::string what = "cannot use " + quoted(path);
  constexpr const char* remedy = "copy or export it again";
  require_file(path);
  if (!has_dicom_header(path)) throw Error(what, "it is not a DICOM file", "choose a DICOM file");
  if (const std::string damage = damage_of_header(path); !damage.empty()) throw Error(what, damage, remedy);
  DicomIdentity identity;
  try {
    for (const DicomSlice& slice : scan_dicom(path))
      if (slice.unreadable.starts_with("truncated")) throw std::runtime_error(slice.unreadable);
    const std::vector<std::string> texts = read_dicom_values(
        path, {{0x0008, 0x0016}, {0x0008, 0x0018}, {0x0020, 0x000d}, {0x0020, 0x000e}, kTransferSyntax});
    identity = {.sop_class = texts[0],
                .sop_instance = texts[1],
                .study = texts[2],
                .series = texts[3],
                .transfer_syntax = texts[4]};
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error(what, message_of(exception), remedy);
  }
  if (identity.sop_class.empty() || identity.sop_instance.empty())
    throw Error(what, "it has no SOP class or instance UID", "choose a DICOM image or another DICOM object");
  return identity;
}

}  // namespace simplexseg
