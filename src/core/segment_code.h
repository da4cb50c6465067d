// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

/// Code of a terminology, as in DICOM (PS3.3 8.8): coding scheme designator, code value, code meaning.
struct CodedConcept {
  std::string scheme, value, meaning;
  bool empty() const { return value.empty(); }
  bool operator==(const CodedConcept&) const = default;
};

/// Codes of a segment in DICOM: property category (CID 7150), property type (CID 7151), and modifier of the type, for
/// example its laterality (CID 244); empty if there is none.
struct SegmentCode {
  CodedConcept category, type, modifier;
  /// Whether there is no code; the code then follows from the name (io/scene/label_preset.h).
  bool empty() const { return type.empty(); }
  bool operator==(const SegmentCode&) const = default;
};

/// Codes of a segment of unknown type: tissue.
const SegmentCode& tissue_code();

/// Reason why DICOM cannot store the codes: a part that is missing or too long, or has a separator or control
/// character. "" if it can, or if there is no code.
std::string fault_of(const SegmentCode& code);

}  // namespace simplexseg
