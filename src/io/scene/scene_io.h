// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "io/scene/history_io.h"
#include "io/scene/log_io.h"
#include "session/scene.h"
#include "session/undo_history.h"

namespace simplexseg {

/// Contents of a scene file (docs/scene-format.md).
struct SceneFile {
  Scene scene;
  std::filesystem::path volume;       ///< file of the volume; empty if the scene has none
  std::vector<std::string> warnings;  ///< warnings about labels from which meshes start, one line each
};
/// Find: searches for the file of the volume (find_data()). Skip: SceneFile::volume stays empty, for a template whose
/// volume may be missing.
enum class SceneVolume { Find, Skip };
/// Reads a scene file and the files of its meshes. Throws Error for an unknown key (with the most similar known key), a
/// value that is not finite or out of range, a missing file, or a mesh without vertices or with a damaged pose file.
SceneFile read_scene(const std::filesystem::path& path, SceneVolume volume = SceneVolume::Find);
/// Writes the scene and, beside it, the pose (NAME.mesh-ID.ply) and the state (NAME.mesh-ID.state) of each mesh, bit
/// for bit, so that the simulation resumes exactly. Also writes the steps of `history` nearest to the present
/// (NAME.history), about `max_bytes` bytes at most, or deletes an old history file if `history` is empty. Writes
/// temporary files and renames them only when all are complete. Throws Error for two meshes with the same name, an
/// invalid mesh, a missing folder, or a failed write.
void write_scene(const std::filesystem::path& path, const Scene& scene, const UndoHistory& history = UndoHistory(),
                 std::size_t max_bytes = kMaxHistoryBytes);

}  // namespace simplexseg
