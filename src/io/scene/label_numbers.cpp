// SPDX-License-Identifier: Apache-2.0
#include "io/scene/label_numbers.h"

#include "io/scene/json_input.h"

namespace simplexseg {

LabelNumbers read_labels(const JsonInput& input) {
  LabelNumbers labels;
  if (input.has("preset")) labels.preset = input["preset"].text();
  if (!input.has("by_name")) return labels;
  const JsonInput names = input["by_name"];
  for (const std::string& name : names.keys()) labels.by_name[name] = names[name].integer_between(1, 65535);
  return labels;
}

}  // namespace simplexseg
