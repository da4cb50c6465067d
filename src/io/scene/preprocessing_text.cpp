// SPDX-License-Identifier: Apache-2.0
#include "io/scene/preprocessing_text.h"

#include "core/error.h"
#include "io/scene/json_input.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {
namespace {

FilterStep filter_from_json(const JsonInput& input) {
  const std::string name = input["name"].text();
  const std::optional<FilterKind> kind = find_filter(name);
  if (!kind) {
    std::vector<std::string> names;
    for (const FilterInfo& info : filter_list()) names.emplace_back(info.name);
    input["name"].fail("the filter " + unknown_name(name, names), "correct it");
  }
  FilterStep step{*kind, default_parameters(*kind)};
  std::vector<std::string> keys = {"name"};
  for (std::size_t n = 0; n < step.parameters.size(); ++n) {
    const std::string& key = keys.emplace_back(info_of(*kind).parameters[n].name);
    if (input.has(key)) step.parameters[n] = input[key].number();
  }
  input.expect_keys(keys);
  return step;
}

}  // namespace

Preprocessing preprocessing_from_json(const JsonInput& input) {
  input.expect_keys({"filters", "checksum"});
  Preprocessing preprocessing;
  const JsonInput filters = input["filters"];
  for (int n = 0; n < filters.size(); ++n) preprocessing.filters.push_back(filter_from_json(filters[n]));
  if (input.has("checksum")) preprocessing.checksum = input["checksum"].text();
  try {
    check_preprocessing(preprocessing);
  } catch (const Error& error) {
    input.fail(error.what(), "correct the filters");
  }
  return preprocessing;
}

}  // namespace simplexseg
