// SPDX-License-Identifier: Apache-2.0
// Filters of images in scene files and logs (docs/scene-format.md).
#pragma once
#include "image/preprocessing.h"

namespace simplexseg {

class JsonInput;

/// JSON of filters and the checksum of their result.
template <class Json>
Json preprocessing_json(const Preprocessing& preprocessing) {
  Json json = {{"filters", Json::array()}};
  for (const FilterStep& step : preprocessing.filters) {
    const FilterInfo& info = info_of(step.kind);
    Json filter = {{"name", info.name}};
    for (std::size_t n = 0; n < info.parameters.size(); ++n) filter[info.parameters[n].name] = step.parameters.at(n);
    json["filters"].push_back(std::move(filter));
  }
  if (!preprocessing.checksum.empty()) json["checksum"] = preprocessing.checksum;
  return json;
}
/// Reads preprocessing_json(); a missing parameter has its default. Throws Error for an unknown filter or key, and for
/// values out of range.
Preprocessing preprocessing_from_json(const JsonInput& input);

}  // namespace simplexseg
