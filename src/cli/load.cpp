// SPDX-License-Identifier: Apache-2.0
#include "cli/load.h"

#include <ostream>

#include "cli/progress.h"
#include "cli/simulate.h"
#include "io/files.h"
#include "io/volume_io.h"

namespace simplexseg {

LoadedScene load_scene(const std::string& path, const std::vector<std::string>& settings, const Console& console) {
  SceneFile file = read_scene(path);
  for (const std::string& setting : settings) set_by_path(file.scene, setting);
  LoadedScene loaded{std::move(file.scene), {}, std::move(file.volume), {}};
  if (loaded.volume_path.empty()) return loaded;
  const Progress progress(console, "reading");
  LoadedVolume volume = load_volume(loaded.volume_path);
  loaded.volume = std::move(volume.volume);
  loaded.warnings = std::move(volume.warnings);
  return loaded;
}

LoadedScene load_scene_header(const std::string& path, const std::vector<std::string>& settings) {
  SceneFile file = read_scene(path);
  for (const std::string& setting : settings) set_by_path(file.scene, setting);
  LoadedScene loaded{std::move(file.scene), {}, std::move(file.volume), {}};
  if (loaded.volume_path.empty()) return loaded;
  VolumeInfo info = read_volume_info(loaded.volume_path);
  loaded.volume = Volume(info.geometry, info.type);
  loaded.warnings = std::move(info.warnings);
  return loaded;
}

EngineChoice engine_for(const std::string& backend, int threads, VolumeSampling sampling) {
  return as_failure([&] {
    if (backend == "cpu") return EngineChoice{make_cpu_engine(threads), {}, ""};
    EngineChoice choice = make_engine(backend == "cuda" ? Backend::Cuda : Backend::Auto, sampling);
    if (threads > 0 && choice.engine->backend() == std::string("cpu")) choice.engine = make_cpu_engine(threads);
    return choice;
  });
}

void print_warnings(const std::vector<std::string>& warnings, const Console& console) {
  for (const std::string& warning : warnings) console.err << "warning: " << one_line(warning, 1000) << "\n";
}

}  // namespace simplexseg
