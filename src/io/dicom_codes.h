// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// SNOMED CT codes for what a segment shows: category (CID 7150) and type (CID 7151).
struct SegmentCode {
  const char *category, *category_meaning;
  const char *type, *type_meaning;
};

/// Of the organ that the name says and nothing else but numbers ("Left kidney 2", "kidney_left", "LIVER"); any other,
/// as "liver tumour", is tissue.
SegmentCode code_of(const std::string& name);

}  // namespace simplexseg
