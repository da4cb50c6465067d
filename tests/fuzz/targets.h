// SPDX-License-Identifier: Apache-2.0
// What is fuzzed: every reader of files that come from elsewhere. The fuzzer (fuzz.cpp) and the test that repeats its
// seeds and findings (tests/io/fuzz_seeds_test.cpp) go by this list.
#pragma once
#include <filesystem>
#include <iterator>
#include <string>

#include "core/error.h"
#include "io/files.h"
#include "io/log_io.h"
#include "io/mesh_io.h"
#include "io/pose_state.h"
#include "io/scene_io.h"
#include "io/volume_io.h"
#include "mesh/simplex_mesh.h"
#include "session/scene.h"

namespace simplexseg::test {

struct FuzzTarget {
  const char* name;                                 ///< the folder of its seeds
  const char* file;                                 ///< what the bytes are written to; the extension chooses the reader
  void (*read)(const std::filesystem::path& path);  ///< may throw Error, nothing else
};

inline void fuzz_volume(const std::filesystem::path& path) {
  const LoadedVolume loaded = load_volume(path);
  loaded.volume.range();
}
/// Whatever is accepted is a valid mesh.
inline void fuzz_mesh(const std::filesystem::path& path) { validate(read_mesh(path)); }
inline void fuzz_state(const std::filesystem::path& path) {
  MeshItem item;
  item.mesh = make_sphere({0, 0, 0}, 10, 0);
  take_pose_state("state", read_bytes(path), item);
}

inline const FuzzTarget fuzz_targets[] = {
    {"scene", "fuzzed.json", [](const std::filesystem::path& path) { read_scene(path); }},
    {"log", "fuzzed.json", [](const std::filesystem::path& path) { read_log(path); }},
    {"state", "fuzzed.state", fuzz_state},
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

/// What is wrong with how the target reads the file: another exception than Error, or a message that is not one line.
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
