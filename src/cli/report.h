// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/metrics.h"
#include "core/scene.h"
#include "core/simplex_mesh.h"

namespace simplexseg {

/// What became of one mesh.
struct MeshReport {
  std::string name;
  int vertices = 0;
  SurfaceMeasures measures{};
  std::optional<Agreement> agreement;  ///< with the reference that the scene names
};

/// What a run did.
struct RunReport {
  std::string scene_path, volume_path;
  VolumeGeometry geometry;
  std::string voxel_type;  ///< empty without a volume
  std::string backend, device, note;
  int threads = 0;                  ///< of the CPU engine; 0 on another
  double load_ms = 0, wall_ms = 0;  ///< reading and making ready; the simulation alone
  std::int64_t steps = 0;
  bool at_rest = false;
  std::vector<std::string> cuts;           ///< one line for each step undone
  std::optional<std::string> failure;
  std::size_t bytes_held = 0;
  std::vector<MeshReport> meshes;

  double step_us() const { return steps > 0 ? 1000 * wall_ms / static_cast<double>(steps) : 0; }
};

/// The truths of a scene's meshes, found and read before a run. Throws Error when one is missing or on another grid
/// than the volume's.
class References {
 public:
  References(const Scene& scene, const std::filesystem::path& scene_folder, const VolumeGeometry& volume);
  /// None where the mesh names no reference.
  std::optional<Agreement> compare_with(const MeshItem& item) const;

 private:
  std::map<std::string, Volume> labels_;  ///< by the path in the scene
};

/// Writes the report as JSON, parameters of `scene` included. Infinite distances are null.
void write_report(const std::filesystem::path& path, const RunReport& report, const Scene& scene);
void print_report(std::ostream& out, const RunReport& report);

}  // namespace simplexseg
