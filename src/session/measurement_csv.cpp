// SPDX-License-Identifier: Apache-2.0
#include "session/measurement_csv.h"

#include <array>
#include <optional>
#include <vector>

#include "core/number_text.h"
#include "session/object_measures.h"
#include "session/run_trace.h"

namespace simplexseg {
namespace {

enum Column {
  kName,
  kKind,
  kLength,
  kAngle,
  kArea,
  kMean,
  kDeviation,
  kMinimum,
  kMaximum,
  kVoxels,
  kVolume,
  kLongAxis,
  kShortAxis,
  kSlice,
  kPoints,
  kColumns
};
constexpr std::array<const char*, kColumns> kHeads = {
    "name",    "kind",   "length_mm",  "angle_degrees", "area_mm2",      "mean",  "deviation", "minimum",
    "maximum", "voxels", "volume_mm3", "long_axis_mm",  "short_axis_mm", "slice", "points_mm"};

using Row = std::array<std::string, kColumns>;

std::string number_field(double value) { return general_text(value, 7); }

/// "x y z; x y z"
std::string points_text(const std::vector<Eigen::Vector3d>& points_mm) {
  std::string text;
  for (const Eigen::Vector3d& p : points_mm)
    text += (text.empty() ? "" : "; ") + number_field(p.x()) + " " + number_field(p.y()) + " " + number_field(p.z());
  return text;
}

Row row_of(const Measurement& measurement, const Volume& volume) {
  Row row;
  row[kName] = csv_field(measurement.name), row[kKind] = name_of(measurement.kind);
  const MeasurementValues values = values_of(measurement, volume);
  if (values.length_mm) row[kLength] = number_field(*values.length_mm);
  if (values.angle_degrees) row[kAngle] = number_field(*values.angle_degrees);
  if (values.area_mm2) row[kArea] = number_field(*values.area_mm2);
  if (const auto& found = values.intensities) {
    row[kMean] = number_field(found->mean), row[kDeviation] = number_field(found->deviation);
    row[kMinimum] = number_field(found->minimum), row[kMaximum] = number_field(found->maximum);
    row[kVoxels] = std::to_string(found->voxels);
  }
  row[kPoints] = points_text(measurement.points_mm);
  return row;
}

Row row_of(const MeshItem& item, const Scene& scene, const Volume& volume) {
  Row row;
  row[kName] = csv_field(item.name), row[kKind] = "segmentation";
  const ObjectMeasures measures = measure_object(item, scene, volume);
  row[kVolume] = number_field(measures.volume_mm3);
  if (measures.intensities) {
    row[kMean] = number_field(measures.intensities->mean),
    row[kDeviation] = number_field(measures.intensities->deviation);
    row[kVoxels] = std::to_string(measures.intensities->voxels);
  }
  if (const std::optional<ObjectAxes>& axes = measures.axes) {
    row[kLongAxis] = number_field(axes->long_mm()), row[kShortAxis] = number_field(axes->short_mm());
    row[kSlice] = std::to_string(axes->slice);
    row[kPoints] =
        points_text({axes->long_ends_mm[0], axes->long_ends_mm[1], axes->short_ends_mm[0], axes->short_ends_mm[1]});
  }
  return row;
}

}  // namespace

std::string measurement_csv(const Scene& scene, const Volume& volume) {
  std::string text;
  const auto add = [&text](const auto& fields) {
    for (int column = 0; column < kColumns; ++column) {
      if (column > 0) text += ',';
      text += fields[static_cast<std::size_t>(column)];
    }
    text += '\n';
  };
  add(kHeads);
  for (const Measurement& measurement : scene.measurements) add(row_of(measurement, volume));
  for (const MeshItem& item : scene.meshes)
    if (!item.mesh.positions.empty()) add(row_of(item, scene, volume));
  return text;
}

}  // namespace simplexseg
