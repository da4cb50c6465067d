// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// SNOMED CT codes of a segment: property category (CID 7150) and property type (CID 7151).
struct SegmentCode {
  const char *category, *category_meaning;
  const char *type, *type_meaning;
};

/// Returns the codes of an organ if the name contains only the words of the organ, in any order, and numbers ("Left
/// kidney 2", "kidney_left", "LIVER"). Returns the code of tissue for any other name, e.g. "liver tumour".
SegmentCode code_of(const std::string& name);

}  // namespace simplexseg
