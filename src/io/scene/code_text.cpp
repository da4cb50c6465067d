// SPDX-License-Identifier: Apache-2.0
#include "io/scene/code_text.h"

#include "io/scene/json_input.h"

namespace simplexseg {

CodedConcept read_concept(const JsonInput& input) {
  input.expect_keys({"scheme", "code", "meaning"});
  return {input.has("scheme") ? input["scheme"].text() : "SCT", input["code"].text(), input["meaning"].text()};
}

SegmentCode read_code(const JsonInput& input) {
  input.expect_keys({"category", "type", "modifier"});
  SegmentCode code;
  if (input.has("category")) code.category = read_concept(input["category"]);
  if (input.has("type")) code.type = read_concept(input["type"]);
  if (input.has("modifier")) code.modifier = read_concept(input["modifier"]);
  if (const std::string fault = fault_of(code); !fault.empty()) input.fail(fault, "correct it");
  return code;
}

}  // namespace simplexseg
