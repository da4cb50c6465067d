// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "gpu/backend.h"
#include "io/scene_io.h"
#include "session/session.h"

namespace simplexseg {

/// A scene and its volume, read, with the --set options applied.
struct LoadedScene {
  Scene scene;
  Volume volume;
  std::filesystem::path volume_path;  ///< where it was found; empty when the scene names none
  std::vector<std::string> warnings;  ///< of the volume; for print_warnings() once nothing can be refused any more
};
/// Throws Error as the readers do.
LoadedScene load_scene(const std::string& path, const std::vector<std::string>& settings, const Console& console);
/// The same without reading a voxel: the volume has its geometry and type, and zeros.
LoadedScene load_scene_header(const std::string& path, const std::vector<std::string>& settings);
/// `backend`: "auto", "cpu" or "cuda"; `threads` of the CPU, 0: as many as there are. Throws Failure where it cannot be
/// had.
EngineChoice engine_for(const std::string& backend, int threads, VolumeSampling sampling = VolumeSampling::Filtered);
/// Later than any refusal: bad input is answered in one line.
void print_warnings(const std::vector<std::string>& warnings, const Console& console);

}  // namespace simplexseg
