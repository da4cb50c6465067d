// SPDX-License-Identifier: Apache-2.0
// Labels of names in scene files and logs.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// JSON object with the keys `preset` and `by_name`, each if it is not empty.
template <class Json>
Json labels_json(const LabelNumbers& labels) {
  Json json = Json::object();
  if (!labels.preset.empty()) json["preset"] = labels.preset;
  for (const auto& [name, label] : labels.by_name) json["by_name"][name] = label;
  return json;
}

/// Reads `preset` and `by_name` of an object, which may have other keys.
LabelNumbers read_labels(const JsonInput& input);

}  // namespace simplexseg
