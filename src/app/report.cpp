// SPDX-License-Identifier: Apache-2.0
#include "app/report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>
#include <thread>

#include "app/metric_list.h"
#include "app/table.h"
#include "core/number_text.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"
#include "io/scene/json_output.h"
#include "session/paint.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
using Json = nlohmann::ordered_json;

namespace {

Json parameters_json(const Scene& scene) {
  Json simulation = Json::object(), meshes = Json::object();
  for (std::size_t p = 0; p < simulation_table().size(); ++p) {
    add_parameter(simulation, simulation_table()[p], value_of(scene.simulation, static_cast<int>(p)));
  }
  for (const MeshItem& item : scene.meshes) {
    for (const ForceInfo& force : force_list()) {
      for (std::size_t p = 0; p < force.parameters.size(); ++p) {
        add_parameter(meshes[item.name][force.name], force.parameters[p],
                      item.parameters.values[static_cast<int>(force.id)][p]);
      }
    }
  }
  return {{"simulation", simulation}, {"meshes", meshes}};
}

/// Samples as one list for each quantity, with one value for each sample.
Json trace_json(const std::vector<TraceSample>& trace) {
  Json json = Json::object();
  for (const TraceSample& s : trace) {
    json["seconds"].push_back(s.seconds);
    json["steps"].push_back(s.steps);
    json["vertices"].push_back(s.vertices);
    json["residual_mm"].push_back(s.residual_mm);
    json["mean_move_mm"].push_back(s.mean_move_mm);
    if (!s.error) continue;
    json["error_mean_mm"].push_back(s.error->mean_mm);
    json["error_p95_mm"].push_back(s.error->p95_mm);
    json["error_max_mm"].push_back(s.error->max_mm);
  }
  return json;
}

Json mesh_json(const MeshReport& mesh) {
  Json json = {{"name", mesh.name},
               {"vertices", mesh.vertices},
               {"volume_mm3", mesh.measures.volume_mm3},
               {"area_mm2", mesh.measures.area_mm2}};
  if (mesh.axes) {
    json["long_axis_mm"] = mesh.axes->long_mm(), json["short_axis_mm"] = mesh.axes->short_mm();
    json["axes_slice"] = mesh.axes->slice;
  }
  for (const Metric& metric : metric_list()) {
    if (mesh.agreement) json[metric.key] = metric.value(*mesh.agreement);
  }
  if (mesh.field) {
    json["expected_dice"] = mesh.field->expected_dice;
    json["unsure"] = mesh.field->probably_wrong();
    json["leaks"] = mesh.field->leaks;
    if (mesh.field->intensity_range.is_limited()) json["range_effect"] = name_of(mesh.field->range_effect);
    if (!mesh.field->problem.empty()) json["problem"] = mesh.field->problem;
  }
  if (!mesh.model.empty()) json["model"] = mesh.model;
  if (!mesh.trace.empty()) json["trace"] = trace_json(mesh.trace);
  return json;
}

Json measurement_values_json(const Measurement& measurement, const MeasurementValues& values) {
  Json json = measurement_json<Json>(measurement.kind, measurement.points_mm, measurement.name);
  if (values.length_mm) json["length_mm"] = *values.length_mm;
  if (values.angle_degrees) json["angle_degrees"] = *values.angle_degrees;
  if (values.area_mm2) json["area_mm2"] = *values.area_mm2;
  if (values.intensities) {
    json["mean"] = values.intensities->mean, json["deviation"] = values.intensities->deviation;
    json["minimum"] = values.intensities->minimum, json["maximum"] = values.intensities->maximum;
    json["voxels"] = values.intensities->voxels;
  }
  return json;
}

bool is_compared(const RunReport& report) {
  return std::any_of(report.meshes.begin(), report.meshes.end(),
                     [](const MeshReport& m) { return m.agreement.has_value(); });
}

}  // namespace

void describe_engine(RunReport& report, const Engine& engine, int threads) {
  report.backend = engine.backend();
  report.device = engine.description();
  const int all = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  report.threads = report.backend != "cpu" ? 0 : threads > 0 ? threads : all;
}

MeshReport report_of(const MeshItem& item, const Scene& scene, const VolumeGeometry& geometry,
                     const std::optional<Mask>& reference, const MeshTrace* trace) {
  MeshReport report{item.name,  item.mesh.vertex_count(), measure(item.mesh), object_axes(item.mesh, geometry), {},
                    item.field, item.model_identity()};
  if (reference)
    report.agreement = compare_masks(*reference, object_mask(item.mesh, paint_of(scene, item.id), reference->geometry));
  if (trace) report.trace = trace->samples;
  return report;
}

void add_measurements(RunReport& report, const Scene& scene, const Volume& volume) {
  for (const Measurement& measurement : scene.measurements)
    report.measurements.emplace_back(measurement, values_of(measurement, volume));
}

std::string write_report(const std::filesystem::path& path, const RunReport& report, const Scene& scene) {
  Json json = {{"simplexseg_report", 1}};
  if (!report.scene_path.empty()) json["scene"] = report.scene_path;
  if (!report.voxel_type.empty()) {
    const auto& spacing = report.geometry.spacing_mm;
    json["volume"] = {{"path", report.volume_path},
                      {"size", report.geometry.size},
                      {"spacing_mm", {spacing.x(), spacing.y(), spacing.z()}},
                      {"voxel_type", report.voxel_type}};
  }
  json["backend"] = report.backend;
  json["device"] = report.device;
  if (!report.note.empty()) json["note"] = report.note;
  if (report.threads > 0) json["threads"] = report.threads;
  json["load_ms"] = report.load_ms;
  json["wall_ms"] = report.wall_ms;
  json["steps"] = report.steps;
  json["step_us"] = report.step_us();
  json["at_rest"] = report.at_rest;
  if (!report.warnings.empty()) json["warnings"] = report.warnings;
  if (!report.cuts.empty()) json["timestep_cuts"] = report.cuts;
  if (report.failure) json["failure"] = *report.failure;
  json["bytes_held"] = report.bytes_allocated;
  for (const Metric& metric : metric_list()) {
    if (is_compared(report)) json["metric_definitions"][metric.key] = metric.definition;
  }
  json["meshes"] = Json::array();
  for (const MeshReport& mesh : report.meshes) json["meshes"].push_back(mesh_json(mesh));
  for (const auto& [measurement, values] : report.measurements)
    json["measurements"].push_back(measurement_values_json(measurement, values));
  if (!report.measurements.empty() && !report.intensity_unit.empty()) json["intensity_unit"] = report.intensity_unit;
  json["parameters"] = parameters_json(scene);
  std::string replaced, text;
  try {
    text = json.dump(2);
  } catch (const Json::type_error&) {
    replaced = "a path or name is not UTF-8: the report has U+FFFD in place of its invalid bytes";
    json["warnings"].push_back(replaced);
    text = json.dump(2, ' ', false, Json::error_handler_t::replace);
  }
  AtomicFile file(path);
  write_bytes(file, text + "\n");
  file.commit();
  return replaced;
}

void print_report(std::ostream& out, const RunReport& report) {
  if (!report.voxel_type.empty()) {
    const auto& size = report.geometry.size;
    out << "volume  " << report.volume_path << ", " << size[0] << " x " << size[1] << " x " << size[2] << ", "
        << report.voxel_type << ", loaded in " << fixed_or_dash(report.load_ms / 1000, 2) << " s\n";
  }
  out << "run     " << counted(report.steps, "step") << " in " << fixed_or_dash(report.wall_ms / 1000, 2) << " s, "
      << fixed_or_dash(report.step_us(), 0) << " us per step, " << (report.at_rest ? "settled, " : "") << report.device
      << "\n";
  const bool compared = is_compared(report);
  std::vector<std::vector<std::string>> rows{{"mesh", "vertices", "volume ml", "area cm2", "long mm", "short mm"}};
  if (compared) rows[0].insert(rows[0].end(), {"Dice", "HD mm", "HD95 mm", "ASSD mm", "surface Dice"});
  for (const MeshReport& mesh : report.meshes) {
    rows.push_back({one_line(mesh.name), std::to_string(mesh.vertices), readable(mesh.measures.volume_mm3 / 1000, 2),
                    readable(mesh.measures.area_mm2 / 100, 2), mesh.axes ? readable(mesh.axes->long_mm(), 2) : "-",
                    mesh.axes ? readable(mesh.axes->short_mm(), 2) : "-"});
    if (!mesh.agreement) continue;
    const Agreement& a = mesh.agreement->voxels;
    rows.back().insert(rows.back().end(),
                       {fixed_or_dash(a.dice, 4), readable(a.hd_mm, 2), readable(a.hd95_mm, 2), readable(a.assd_mm, 2),
                        fixed_or_dash(mesh.agreement->surfaces.surface_dice, 4)});
  }
  if (rows.size() > 1) print_table(out, rows, 1);
  std::vector<std::vector<std::string>> measured{{"measurement", "value"}};
  for (const auto& [measurement, values] : report.measurements) {
    std::string text;
    for (const std::string& line : lines_of(values, report.intensity_unit)) text += (text.empty() ? "" : ", ") + line;
    measured.push_back({one_line(measurement.name), text});
  }
  if (measured.size() > 1) print_table(out, measured, 2);
  if (compared)
    out << "HD, HD95, ASSD: distances between the centres of boundary voxels; surface Dice: by area, tolerance "
        << fixed_or_dash(kDefaultToleranceMm, 0) << " mm\n";
}

}  // namespace simplexseg
