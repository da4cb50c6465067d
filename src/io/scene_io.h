// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "io/history_io.h"
#include "io/log_io.h"
#include "session/scene.h"
#include "session/undo_history.h"

namespace simplexseg {

/// A scene file, read: docs/scene-format.md. Throws Error on an unknown key (naming it and the nearest known one), a
/// value that is not finite or out of its table's range, a mesh without vertices or with a broken pose file.
struct SceneFile {
  Scene scene;
  std::filesystem::path volume;       ///< found on disk; empty when the scene names none
  std::vector<std::string> warnings;  ///< of the labels that meshes start from, one line each
};
/// LeaveOut: of a template, whose own volume may be nowhere; `volume` stays empty.
enum class SceneVolume { Find, LeaveOut };
SceneFile read_scene(const std::filesystem::path& path, SceneVolume volume = SceneVolume::Find);
/// Writes the scene and, beside it, the pose of each mesh as PLY (NAME.mesh-ID.ply) and the rest of its state
/// (NAME.mesh-ID.state): read again, the simulation goes on from the same bits. What can be taken back and done again
/// from there goes beside it, too (NAME.history): of `history` the steps that are nearest, in about `most_bytes`; where
/// there are none, such a file of a scene before is removed. Written whole or not at all. Throws Error for two meshes
/// of one name, a mesh that is not valid, a folder that does not exist, or a failed write.
void write_scene(const std::filesystem::path& path, const Scene& scene, const UndoHistory& history = UndoHistory(),
                 std::size_t most_bytes = kMostHistoryBytes);

}  // namespace simplexseg
