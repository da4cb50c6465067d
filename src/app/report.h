// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/metric_list.h"
#include "image/measurement.h"
#include "image/object_axes.h"
#include "mesh/mesh_geometry.h"
#include "mesh/simplex_mesh.h"
#include "session/run_trace.h"
#include "session/scene.h"

namespace simplexseg {

/// Result of one mesh.
struct MeshReport {
  std::string name;
  int vertices = 0;
  SurfaceMeasures measures{};
  std::optional<ObjectAxes> axes;           ///< long and short axis; nullopt: no slice of the volume cuts the mesh
  std::optional<MaskComparison> agreement;  ///< agreement with the reference; nullopt: there is none
  std::shared_ptr<const MeshField> field;   ///< field of the mesh; null: none
  std::string model;                        ///< checksum of the model of its organ; "": none
  std::vector<TraceSample> trace{};         ///< samples taken during the run; empty: not traced
};

/// Result of a run.
struct RunReport {
  std::string scene_path, volume_path;  ///< paths of the files; empty if there is none
  VolumeGeometry geometry;
  std::string voxel_type;  ///< empty if there is no volume
  std::string backend, device, note;
  int threads = 0;                  ///< number of threads of the CPU engine; 0 for other engines
  double load_ms = 0, wall_ms = 0;  ///< time to read and prepare the input; time of the simulation
  std::int64_t steps = 0;
  bool at_rest = false;
  std::vector<std::string> warnings;  ///< warnings of the readers, one line each
  std::vector<std::string> cuts;      ///< one line for each step that was undone and repeated with a smaller timestep
  std::optional<std::string> failure;
  std::size_t bytes_allocated = 0;  ///< memory that the engine uses, bytes
  std::vector<MeshReport> meshes;
  std::vector<std::pair<Measurement, MeasurementValues>> measurements;
  std::string intensity_unit;  ///< unit of the voxels, or ""

  double step_us() const { return steps > 0 ? 1000 * wall_ms / static_cast<double>(steps) : 0; }
};

/// Sets backend, device and threads of the report. `threads`: requested number of CPU threads, 0 for all cores.
void describe_engine(RunReport& report, const Engine& engine, int threads);
/// Measures a mesh of a scene on the grid of its volume, whose size is 0 without one, and, if there is a reference,
/// compares the mesh with it. `trace`: null if the run was not traced.
MeshReport report_of(const MeshItem& item, const Scene& scene, const VolumeGeometry& geometry,
                     const std::optional<Mask>& reference, const MeshTrace* trace);
/// Adds the measurements of a scene and their values.
void add_measurements(RunReport& report, const Scene& scene, const Volume& volume);

/// Writes the report as JSON, with the parameters of `scene`; infinite distances become null. Replaces invalid bytes of
/// a path or name that is not UTF-8 by U+FFFD, adds a warning to the report and returns it, else "". Throws Error for a
/// failed write.
std::string write_report(const std::filesystem::path& path, const RunReport& report, const Scene& scene);
/// Prints the report as text.
void print_report(std::ostream& out, const RunReport& report);

}  // namespace simplexseg
