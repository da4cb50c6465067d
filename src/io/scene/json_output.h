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
#include "image/intensity_range.h"
#include "image/measurement.h"
#include "image/paint_stroke.h"
#include "io/platform/files.h"
#include "io/scene/parameter_text.h"
#include "session/voxel_edit.h"

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

/// JSON object with the finite limits of a range.
template <class Json>
Json range_json(const IntensityRange& range) {
  Json json = Json::object();
  if (std::isfinite(range.low)) json["low"] = range.low;
  if (std::isfinite(range.high)) json["high"] = range.high;
  return json;
}

/// JSON object of a set of painted voxels.
template <class Json>
Json voxels_json(const PaintVoxels& voxels) {
  const VolumeGeometry& box = voxels.box;
  Json direction = Json::array();
  for (int a = 0; a < 3; ++a) direction.push_back(vector_json<Json>(box.direction.col(a)));
  std::string runs;  // as one text, which takes a line of the file instead of one for each run
  for (const std::uint32_t run : runs_of(voxels.voxels)) {
    if (!runs.empty()) runs += ' ';
    runs += std::to_string(run);
  }
  return {{"size", box.size},
          {"spacing_mm", vector_json<Json>(box.spacing_mm)},
          {"origin_mm", vector_json<Json>(box.origin_mm)},
          {"direction", direction},
          {"runs", runs}};
}

/// JSON object of paint: a UserPoint, or an AddPoint, which has no voxels.
template <class Json>
Json paint_json(const auto& point) {
  Json json = Json::object();
  if (point.brush.shape == PaintBrush::Shape::Contour) json["contour"] = true;
  if (point.brush.normal.norm() > 0)
    json["normal"] = vector_json<Json>(point.brush.normal), json["thickness_mm"] = point.brush.thickness_mm;
  if (point.edit != VoxelEdit::None) json["edit"] = info_of(point.edit).name;
  if constexpr (requires { point.voxels; })
    if (point.voxels) json["voxels"] = voxels_json<Json>(*point.voxels);
  return json;
}

/// JSON object of a measurement, without its id.
template <class Json>
Json measurement_json(MeasurementKind kind, const std::vector<Eigen::Vector3d>& points_mm, const std::string& name) {
  Json json = {{"kind", name_of(kind)}, {"points_mm", path_json<Json>(points_mm)}};
  if (!name.empty()) json["name"] = name;
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
