// SPDX-License-Identifier: Apache-2.0
// Codes of segments in scene files, logs and label presets.
#pragma once
#include "core/segment_code.h"

namespace simplexseg {

class JsonInput;

/// JSON object of the parts of the code that are not empty.
template <class Json>
Json code_json(const SegmentCode& code) {
  const auto json_of = [](const CodedConcept& one) {
    return Json{{"scheme", one.scheme}, {"code", one.value}, {"meaning", one.meaning}};
  };
  Json json = Json::object();
  if (!code.category.empty()) json["category"] = json_of(code.category);
  if (!code.type.empty()) json["type"] = json_of(code.type);
  if (!code.modifier.empty()) json["modifier"] = json_of(code.modifier);
  return json;
}

/// Reads `code`, `meaning` and `scheme`; without a scheme it is SCT, SNOMED CT.
CodedConcept read_concept(const JsonInput& input);
/// Reads the object of code_json(). Throws Error unless DICOM can store the codes.
SegmentCode read_code(const JsonInput& input);

}  // namespace simplexseg
