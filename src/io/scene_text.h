// SPDX-License-Identifier: Apache-2.0
// The JSON of a scene, without the files that it names.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// Takes into an item what its JSON names besides: the start with its seed, pose and state. Called when the item has
/// its name, its final vertices and the scene's parameters.
using MeshReader = std::function<void(const JsonInput& mesh, MeshItem& item)>;

/// A scene as docs/scene-format.md has it; meshes have the ids 1, 2, ..., points the next. `folder`: where the file
/// lies. Throws Error for an unknown key or a bad value.
Scene scene_of(const JsonInput& input, const std::filesystem::path& folder, const MeshReader& read_files);
/// The text that scene_of() takes. `path`: of the file that it is for; `poses`: of each mesh the name of the files with
/// its pose and state, without their endings; empty: none. Throws Error for meshes of one name or without one, a point
/// of no mesh, or a name that is not UTF-8.
std::string scene_text(const std::filesystem::path& path, const Scene& scene, const std::vector<std::string>& poses,
                       int indent = 2);

/// A path that was found beside the scene or in the present folder is kept absolute, so that it stays right when the
/// scene is saved elsewhere; one found in a folder of data, or nowhere, stays as it is written.
std::string anchored(const std::string& path, const std::filesystem::path& folder);

}  // namespace simplexseg
