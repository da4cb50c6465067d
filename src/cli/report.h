// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/metric_list.h"
#include "mesh/mesh_geometry.h"
#include "mesh/simplex_mesh.h"
#include "session/run_trace.h"
#include "session/scene.h"

namespace simplexseg {

/// What became of one mesh.
struct MeshReport {
  std::string name;
  int vertices = 0;
  SurfaceMeasures measures{};
  std::optional<MaskComparison> agreement;  ///< with the reference that the scene names
  std::vector<TraceSample> trace;           ///< what was measured during the run
  std::shared_ptr<const MeshField> field;   ///< that it learned; null: none
};

/// What a run did.
struct RunReport {
  std::string scene_path, volume_path;  ///< a scene that is no file has none
  VolumeGeometry geometry;
  std::string voxel_type;  ///< empty without a volume
  std::string backend, device, note;
  int threads = 0;                  ///< that the CPU engine has; 0 on another
  double load_ms = 0, wall_ms = 0;  ///< reading and making ready; the simulation alone
  std::int64_t steps = 0;
  bool at_rest = false;
  std::vector<std::string> warnings;  ///< of what was read, one line each
  std::vector<std::string> cuts;      ///< one line for each step undone
  std::optional<std::string> failure;
  std::size_t bytes_held = 0;
  std::vector<MeshReport> meshes;

  double step_us() const { return steps > 0 ? 1000 * wall_ms / static_cast<double>(steps) : 0; }
};

/// Backend, device and threads of an engine; `threads` as they were asked for, 0: as many as the machine has.
void describe_engine(RunReport& report, const Engine& engine, int threads);
/// Measures a mesh, and compares it where it has a reference. `trace`: null: there is none.
MeshReport report_of(const MeshItem& item, const std::optional<Mask>& reference, const MeshTrace* trace);

/// Writes the report as JSON, parameters of `scene` included. Infinite distances are null.
void write_report(const std::filesystem::path& path, const RunReport& report, const Scene& scene);
void print_report(std::ostream& out, const RunReport& report);

}  // namespace simplexseg
