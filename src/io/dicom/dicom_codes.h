// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// SNOMED CT codes of a segment with their meanings: property category (CID 7150) and property type (CID 7151).
struct SegmentCode {
  const char *category, *category_meaning;
  const char *type, *type_meaning;
};

/// Returns the codes of an organ if `name` consists of all words of the organ's name, in any order and case, and
/// optionally numbers ("Left kidney 2", "kidney_left", "LIVER"). Returns the codes of tissue for any other name, e.g.
/// "liver tumour".
SegmentCode code_of(const std::string& name);

}  // namespace simplexseg
