// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/segment_code.h"
#include "io/dicom_write/dicom_seg_write.h"
#include "io/dicom_write/dicom_source.h"
#include "session/object_measures.h"

namespace simplexseg {

/// Object of a structured report.
struct ReportedObject {
  int label = 0;  ///< value of its voxels; its segment is the one of this label
  SegmentCode code;
  ObjectMeasures measures;
};

/// Throws Error if this program was built without the library that writes structured reports.
void require_structured_reports(const std::filesystem::path& path);

/// Writes the measures of objects as DICOM Comprehensive 3D SR by the template TID 1500, Measurement Report, with a
/// group of TID 1411 for each object: volume (mm3), mean and standard deviation of the intensities, and long and short
/// axis (mm). The groups refer to the segments of `segmentation` and have their tracking identifiers. `unit`: of the
/// intensities, as LoadedInput::intensity_unit. Throws Error if an object has no segment or two have the same one, a
/// text cannot be stored, the program was built without DCMTK, or the file cannot be written.
void write_structured_report(const std::filesystem::path& path, const std::vector<ReportedObject>& objects,
                             const std::string& unit, const WrittenSegmentation& segmentation, DicomSource source);

}  // namespace simplexseg
