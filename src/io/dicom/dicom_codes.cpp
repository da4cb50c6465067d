// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_codes.h"

#include "io/dicom/dicom_texts.h"

namespace simplexseg {

SegmentCode read_segment_code(const gdcm::DataSet& item, DicomTag type, const std::string& coding) {
  const auto concept_in = [&](const gdcm::DataSet& code) {
    return CodedConcept{text_of(code, {0x0008, 0x0102}), text_of(code, {0x0008, 0x0100}),
                        utf8_of(raw_text_of(code, {0x0008, 0x0104}), coding)};
  };
  SegmentCode code;
  first_item(item, {0x0062, 0x0003}, [&](const gdcm::DataSet& category) { code.category = concept_in(category); });
  first_item(item, type, [&](const gdcm::DataSet& property) {
    code.type = concept_in(property);
    first_item(property, {0x0062, 0x0011},
               [&](const gdcm::DataSet& modifier) { code.modifier = concept_in(modifier); });
  });
  return fault_of(code).empty() ? code : SegmentCode{};
}

}  // namespace simplexseg
