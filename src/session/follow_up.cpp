// SPDX-License-Identifier: Apache-2.0
#include "session/follow_up.h"

#include <algorithm>
#include <map>

#include "core/number_text.h"
#include "image/metrics.h"
#include "image/object_axes.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "session/run_trace.h"

namespace simplexseg {
namespace {

constexpr double kMm3PerMl = 1000;

std::string field(double value) { return general_text(value, 7); }
/// Axes of 0 are unknown.
std::string length_field(double mm) { return mm > 0 ? field(mm) : ""; }

std::string line_of(const std::vector<std::string>& fields) {
  std::string line;
  for (const std::string& one : fields) line.append(line.empty() && &one == fields.data() ? "" : ",").append(one);
  return line + "\n";
}

}  // namespace

EarlierObject measures_of(const SimplexMesh& mesh, const VolumeGeometry& geometry) {
  EarlierObject object;
  const SurfaceMeasures measures = measure(mesh);
  object.volume_ml = measures.volume_mm3 / kMm3PerMl;
  object.centroid_mm = measures.centroid_mm;
  if (const std::optional<ObjectAxes> axes = object_axes(mesh, geometry))
    object.long_mm = axes->long_mm(), object.short_mm = axes->short_mm();
  return object;
}

std::vector<FollowUpRow> follow_up_rows(const Scene& scene, const VolumeGeometry& geometry) {
  std::vector<FollowUpRow> rows;
  for (const MeshItem& item : scene.meshes) {
    if (!item.start || !(item.start->earlier.volume_ml > 0) || item.mesh.positions.empty()) continue;
    FollowUpRow& row = rows.emplace_back();
    row.name = item.name, row.colour = item.colour, row.locked = item.locked;
    row.earlier = item.start->earlier;
    row.now = measures_of(item.mesh, geometry);
    const SurfaceMeasures carried = measure(*item.start->mesh);
    row.carried_ml = carried.volume_mm3 / kMm3PerMl;
    row.shift_mm = (row.now.centroid_mm - carried.centroid_mm).norm();
    row.unregistered_shift_mm = (row.now.centroid_mm - row.earlier.centroid_mm).norm();
    row.dice = dice(rasterise(*item.start->mesh, geometry), rasterise(item.mesh, geometry));
  }
  return rows;
}

std::string follow_up_csv(const std::vector<FollowUpRow>& rows) {
  std::string text =
      line_of({"name", "locked", "earlier_ml", "now_ml", "change_ml", "change_percent", "carried_ml", "earlier_long_mm",
               "now_long_mm", "earlier_short_mm", "now_short_mm", "shift_mm", "unregistered_shift_mm", "dice_carried"});
  for (const FollowUpRow& row : rows)
    text += line_of({csv_field(row.name), row.locked ? "1" : "0", field(row.earlier.volume_ml),
                     field(row.now.volume_ml), field(row.change_ml()), field(row.change_percent()),
                     field(row.carried_ml), length_field(row.earlier.long_mm), length_field(row.now.long_mm),
                     length_field(row.earlier.short_mm), length_field(row.now.short_mm), field(row.shift_mm),
                     field(row.unregistered_shift_mm), field(row.dice)});
  return text;
}

std::vector<TimePointObject> objects_of(const Scene& scene, const VolumeGeometry& geometry) {
  std::vector<TimePointObject> objects;
  for (const MeshItem& item : scene.meshes)
    if (!item.mesh.positions.empty()) objects.push_back({item.name, item.colour, measures_of(item.mesh, geometry)});
  return objects;
}

std::string curve_csv(const std::vector<TimePoint>& points) {
  std::string text =
      line_of({"time_point", "time_s", "name", "volume_ml", "long_mm", "short_mm", "x_mm", "y_mm", "z_mm"});
  for (const TimePoint& point : points)
    for (const TimePointObject& object : point.objects) {
      const EarlierObject& m = object.measures;
      text += line_of({std::to_string(point.number), point.time_s ? field(*point.time_s) : "", csv_field(object.name),
                       field(m.volume_ml), length_field(m.long_mm), length_field(m.short_mm), field(m.centroid_mm.x()),
                       field(m.centroid_mm.y()), field(m.centroid_mm.z())});
    }
  return text;
}

Plot curve_plot(const std::vector<TimePoint>& points) {
  constexpr double kMostSecondsInMs = 10;
  const bool timed = std::ranges::all_of(points, [](const TimePoint& p) { return p.time_s.has_value(); });
  const bool in_ms =
      timed && std::ranges::all_of(points, [](const TimePoint& p) { return *p.time_s <= kMostSecondsInMs; });
  Plot plot;
  plot.x_title = !timed ? "time point" : in_ms ? "time, ms" : "time, s";
  plot.y_title = "volume, ml";
  std::map<std::string, std::size_t> series_of;
  for (const TimePoint& point : points)
    for (const TimePointObject& object : point.objects) {
      const auto [found, is_new] = series_of.emplace(object.name, plot.series.size());
      if (is_new) {
        PlotSeries& series = plot.series.emplace_back();
        series.name = object.name, series.colour = object.colour, series.markers = true;
      }
      PlotSeries& series = plot.series[found->second];
      series.x.push_back(!timed ? point.number : *point.time_s * (in_ms ? 1000 : 1));
      series.y.push_back(object.measures.volume_ml);
    }
  return plot;
}

}  // namespace simplexseg
