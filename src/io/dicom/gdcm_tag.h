// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gdcmTag.h>

#include "io/dicom/dicom_values.h"

namespace simplexseg {

/// Converts a tag to GDCM's type.
inline gdcm::Tag tag_of(DicomTag tag) { return {tag.group, tag.element}; }

}  // namespace simplexseg
