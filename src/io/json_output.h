// SPDX-License-Identifier: Apache-2.0
// Templates over the JSON library's type, so that this header does not include it.
#pragma once
#include <cmath>
#include <filesystem>
#include <string>

#include "core/error.h"
#include "forces/parameters.h"
#include "io/files.h"
#include "io/parameter_text.h"

namespace simplexseg {

/// Adds a parameter to a JSON object: a Choice by its name, an Integer as a whole number.
template <class Json>
void put_parameter(Json& object, const ParameterInfo& info, float value) {
  switch (info.kind) {
    case ParameterKind::Choice:
      object[info.name] = parameter_to_text(info, value);
      break;
    case ParameterKind::Integer:
      object[info.name] = std::lround(value);
      break;
    case ParameterKind::Real:
      object[info.name] = short_double(value);
      break;
  }
}

/// The text of a JSON file; with an indent of -1 one line. Throws Error for a name that is not UTF-8.
template <class Json>
std::string json_text(const std::filesystem::path& path, const Json& json, int indent = 2) {
  try {
    return json.dump(indent) + "\n";
  } catch (const typename Json::type_error&) {
    throw Error("cannot write " + quoted(path), "a name or path in it is not UTF-8", "rename it");
  }
}

}  // namespace simplexseg
