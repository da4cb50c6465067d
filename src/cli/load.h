// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "core/session.h"
#include "gpu/backend.h"
#include "io/scene_io.h"

namespace simplexseg {

/// A scene and its volume, read, with the --set options applied.
struct LoadedScene {
  Scene scene;
  Volume volume;
  std::filesystem::path volume_path;  ///< where it was found; empty when the scene names none
};
/// Warnings of the volume go to the console. Throws Error as the readers do.
LoadedScene load_scene(const std::string& path, const std::vector<std::string>& settings, const Console& console);

}  // namespace simplexseg
