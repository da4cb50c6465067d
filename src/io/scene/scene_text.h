// SPDX-License-Identifier: Apache-2.0
// JSON of a scene, without the files to which it refers.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// Callback that reads the other files of a mesh into `item`: start with seed, pose and state. Called when `item` has
/// its name, its final number of vertices and the force parameters of the scene.
using MeshReader = std::function<void(const JsonInput& mesh, MeshItem& item)>;

/// Scene from its JSON (docs/scene-format.md). Meshes get the ids 1, 2, ..., points the ids after them. `folder`:
/// folder of the scene file. Throws Error for an unknown key or an invalid value.
Scene scene_of(const JsonInput& input, const std::filesystem::path& folder, const MeshReader& read_files);
/// JSON text of a scene, for scene_of(). `path`: scene file; `poses`: name of the pose and state files of each mesh
/// without extension, "" for a mesh without these files; `indent`: see json_text(). Throws Error for a missing or
/// duplicate name of a mesh, a point without a mesh, or a name that is not UTF-8.
std::string scene_text(const std::filesystem::path& path, const Scene& scene, const std::vector<std::string>& poses,
                       int indent = 2);

/// Absolute path of a file that exists relative to the current folder or to `folder`, so that the path stays valid if
/// the scene is saved elsewhere. Other paths are returned unchanged.
std::string absolute_if_found(const std::string& path, const std::filesystem::path& folder);

}  // namespace simplexseg
