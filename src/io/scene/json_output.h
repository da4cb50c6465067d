// SPDX-License-Identifier: Apache-2.0
// Writer for JSON files. Templates over the JSON type keep the JSON library out of this header.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "forces/parameters.h"
#include "image/paint_stroke.h"
#include "io/platform/files.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {

/// Adds a parameter to a JSON object: a Choice as its name, an Integer as a whole number, a Real as a short decimal.
template <class Json>
void add_parameter(Json& object, const ParameterInfo& info, float value) {
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

/// JSON array of the three coordinates.
template <class Json>
Json vector_json(const Eigen::Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

/// JSON array of points or offsets.
template <class Json>
Json path_json(const std::vector<Eigen::Vector3d>& path) {
  Json array = Json::array();
  for (const Eigen::Vector3d& vertex : path) array.push_back(vector_json<Json>(vertex));
  return array;
}

/// JSON object of the brush of a stroke of paint; empty for a ball.
template <class Json>
Json brush_json(const PaintBrush& brush) {
  Json json = Json::object();
  if (brush.shape == PaintBrush::Shape::Disc)
    json = {{"normal", vector_json<Json>(brush.normal)}, {"thickness_mm", brush.thickness_mm}};
  return json;
}

/// Text of a JSON file. `path`: file in messages; `indent`: blanks per level, -1 for a single line. Throws Error for a
/// text that is not UTF-8.
template <class Json>
std::string json_text(const std::filesystem::path& path, const Json& json, int indent = 2) {
  try {
    return json.dump(indent) + "\n";
  } catch (const typename Json::type_error&) {
    throw Error("cannot write " + quoted(path), "a name or path is not UTF-8", "rename it");
  }
}

}  // namespace simplexseg
