// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "session/command.h"
#include "session/scene.h"

namespace simplexseg {

/// A scene file, read: docs/scene-format.md. Throws Error on an unknown key (naming it and the nearest known one), a
/// value that is not finite or out of its table's range, a mesh without vertices or with a broken pose file.
struct SceneFile {
  Scene scene;
  std::filesystem::path volume;  ///< found on disk; empty when the scene names none
};
SceneFile read_scene(const std::filesystem::path& path);
/// Writes the scene and, beside it, the pose of each mesh as PLY (NAME.mesh-ID.ply) and the rest of its state
/// (NAME.mesh-ID.state): read again, the simulation goes on from the same bits. Written whole or not at all. Throws
/// Error for two meshes of one name, a mesh that is not valid, a folder that does not exist, or a failed write.
void write_scene(const std::filesystem::path& path, const Scene& scene);

/// Where a path of a scene file is looked for: as it is, beside the scene, in the folders of SIMPLEXSEG_DATA
/// (colon-separated), in the templates of Debian's mricron-data. Throws Error listing these when it is nowhere.
std::filesystem::path find_data(const std::string& path, const std::filesystem::path& beside);

/// Applies "meshes.NAME.FORCE.PARAMETER=V", "forces.FORCE.PARAMETER=V" (every mesh) or "simulation.PARAMETER=V".
void set_by_path(Scene& scene, const std::string& assignment);

/// `scene` says in the file what the log belongs to; replay applies it to the scene at hand all the same.
void write_log(const std::filesystem::path& path, const std::vector<LogEntry>& log, int trailing_steps,
               const std::string& scene = "");
struct LogFile {
  std::vector<LogEntry> log;
  int trailing_steps;
  std::string scene;  ///< empty when the file does not say
};
LogFile read_log(const std::filesystem::path& path);

}  // namespace simplexseg
