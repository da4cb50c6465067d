// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_identity.h"

#include <gdcmReader.h>

#include "core/error.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_validation.h"
#include "io/dicom/dicom_values.h"
#include "io/platform/files.h"
#include "io/platform/quiet_libraries.h"

namespace simplexseg {

DicomIdentity read_dicom_identity(const std::filesystem::path& path) {
  const std::string what = "cannot use " + quoted(path);
  constexpr const char* remedy = "copy or export it again";
  require_file(path);
  if (!has_dicom_header(path)) throw Error(what, "it is not a DICOM file", "choose a DICOM file");
  if (const std::string damage = damage_of_header(path); !damage.empty()) throw Error(what, damage, remedy);
  DicomIdentity identity;
  const QuietLibraries quiet;
  try {
    for (const DicomSlice& slice : scan_dicom(path))
      if (slice.unreadable.starts_with("truncated")) throw std::runtime_error(slice.unreadable);
    without_aborting([&] {
      gdcm::Reader reader;
      reader.SetFileName(path.c_str());
      if (!reader.ReadUpToTag(gdcm::Tag(0x0020, 0x000e), {gdcm::Tag(0x7fe0, 0x0010)})) return;
      const gdcm::DataSet& data = reader.GetFile().GetDataSet();
      identity.sop_class = raw_text_of(data, {0x0008, 0x0016});
      identity.sop_instance = raw_text_of(data, {0x0008, 0x0018});
      identity.study = raw_text_of(data, {0x0020, 0x000d});
      identity.series = raw_text_of(data, {0x0020, 0x000e});
      const char* const syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax().GetString();
      identity.transfer_syntax = syntax ? syntax : "";
    });
  } catch (const std::exception& exception) {
    throw Error(what, message_of(exception), remedy);
  }
  if (identity.sop_class.empty() || identity.sop_instance.empty())
    throw Error(what, "it has no SOP class or instance UID", "choose a DICOM image or another DICOM object");
  return identity;
}

}  // namespace simplexseg
