// SPDX-License-Identifier: Apache-2.0
#include "io/reader/requests.h"

#include <gdcmTrace.h>

#include "io/dicom/dicom_requests.h"
#include "io/volume/minc_requests.h"

namespace simplexseg {

RequestTable reader_requests() {
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  RequestTable all;
  add_request(all, kDicomHeaders, in_reader::scan_dicom_files);
  add_request(all, kDicomClassName, in_reader::sop_class_name);
  add_request(all, kDicomIsReadable, in_reader::is_readable_dicom);
  add_request(all, kDicomTexts, in_reader::read_dicom_values);
  add_request(all, kDicomdirNames, in_reader::names_in_dicomdir);
  add_request(all, kStructureRegions, in_reader::read_structure_regions);
  add_stream(all, kDicomPixels, in_reader::decode_pixels);
  add_request(all, kMincHeader, in_reader::describe_minc);
  add_stream(all, kMincVoxels, in_reader::read_minc_voxels);
  return all;
}

}  // namespace simplexseg
