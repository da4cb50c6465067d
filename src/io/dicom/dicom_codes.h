// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "core/segment_code.h"
#include "io/dicom/dicom_values.h"

namespace simplexseg {

/// Codes of a segment or region: its property category, and the first code of the sequence `type` with its modifier.
/// None if the category or the type is missing or cannot be stored. `coding`: character set of the file.
SegmentCode read_segment_code(const gdcm::DataSet& item, DicomTag type, const std::string& coding);

}  // namespace simplexseg
