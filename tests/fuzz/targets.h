// SPDX-License-Identifier: Apache-2.0
// Fuzz targets: all readers of external files. Used by the fuzzer (fuzz.cpp) and by the test that repeats its seeds and
// findings (tests/io/fuzz_seeds_test.cpp).
#pragma once
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/error.h"
#include "image/volume.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/files.h"
#include "io/scene/history_io.h"
#include "io/scene/log_io.h"
#include "io/scene/pose_state.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "mesh/simplex_mesh.h"
#include "session/scene.h"
#include "session/undo_history.h"
#include "step/simulation_parameters.h"

namespace simplexseg::test {

struct FuzzTarget {
  const char* name;                                 ///< name of the target and of the folder with its seeds
  const char* file;                                 ///< file that receives the bytes; its extension selects the reader
  void (*read)(const std::filesystem::path& path);  ///< reads the file; may throw only Error
};

inline void fuzz_volume(const std::filesystem::path& path) {
  const LoadedVolume loaded = load_volume(path);
  loaded.volume.range();
}
/// Reads a mesh; an accepted mesh must be valid.
inline void fuzz_mesh(const std::filesystem::path& path) { validate(read_mesh(path)); }
inline void fuzz_state(const std::filesystem::path& path) {
  MeshItem item;
  item.mesh = make_sphere({0, 0, 0}, 10, 0);
  restore_pose_state("state", read_bytes(path), item);
}

/// Current scene of the seed of a history.
inline Scene fuzz_present() {
  Scene scene;
  scene.simulation = default_simulation_parameters();
  MeshItem& item = scene.meshes.emplace_back();
  item.id = 1, item.name = "a", item.parameters = default_force_parameters();
  item.mesh = make_sphere({0, 0, 0}, 10, 0);
  item.previous = item.mesh.positions;
  item.shape.assign(item.mesh.positions.size(), Vec4{1, 2, 3, 4});
  return scene;
}
/// Reads a history and performs all its undo and redo steps. The checksum is corrected first, because random data would
/// never pass it.
inline void fuzz_history(const std::filesystem::path& path) {
  std::string bytes = read_bytes(path);
  if (bytes.size() > 4) {
    const std::size_t end = bytes.size() - 4;
    const auto crc = crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), end - 1);
    for (std::size_t byte = 0; byte < 4; ++byte) bytes[end + byte] = static_cast<char>(crc >> (24 - 8 * byte));
  }
  std::ofstream(path, std::ios::binary) << bytes;
  Scene scene = fuzz_present();
  UndoHistory history = read_history(std::filesystem::path(path).replace_extension(".json"), scene, Volume());
  while (history.undo(scene)) {
  }
  while (history.redo(scene)) {
  }
}

inline const FuzzTarget fuzz_targets[] = {
    {"scene", "fuzzed.json", [](const std::filesystem::path& path) { read_scene(path); }},
    {"log", "fuzzed.json", [](const std::filesystem::path& path) { read_log(path); }},
    {"state", "fuzzed.state", fuzz_state},
    {"history", "fuzzed.history", fuzz_history},
    {"ply", "fuzzed.ply", fuzz_mesh},
    {"stl", "fuzzed.stl", fuzz_mesh},
    {"obj", "fuzzed.obj", fuzz_mesh},
    {"vtk", "fuzzed.vtk", fuzz_mesh},
    {"vtp", "fuzzed.vtp", fuzz_mesh},
    {"nifti", "fuzzed.nii", fuzz_volume},
    {"nrrd", "fuzzed.nrrd", fuzz_volume},
    {"meta", "fuzzed.mha", fuzz_volume},
    {"gipl", "fuzzed.gipl", fuzz_volume},
    {"minc", "fuzzed.mnc", fuzz_volume},
    {"dicom", "fuzzed.dcm", fuzz_volume},
};

/// Fault of the target for this file: an exception other than Error, or a message that is not one line; empty: none.
inline std::string fault_of(const FuzzTarget& target, const std::filesystem::path& path) {
  try {
    target.read(path);
  } catch (const Error& error) {
    const std::string text = error.what();
    if (text.size() < 20 || text.find_first_of("\n\r\t") != std::string::npos) return "no line: " + text;
  } catch (const std::exception& exception) {
    return std::string("another exception than Error: ") + exception.what();
  }
  return {};
}

}  // namespace simplexseg::test
