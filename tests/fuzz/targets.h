// SPDX-License-Identifier: Apache-2.0
// Fuzz targets: readers of files (tests/io/fuzz_seeds_test.cpp).
#pragma once
#include <zlib.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "fuzz/target.h"
#include "image/volume.h"
#include "io/mesh/mesh_io.h"
#include "io/model/case_table.h"
#include "io/model/model_file.h"
#include "io/platform/cbor.h"
#include "io/platform/files.h"
#include "io/scene/history_io.h"
#include "io/scene/label_preset.h"
#include "io/scene/log_io.h"
#include "io/scene/pose_state.h"
#include "io/scene/scene_io.h"
#include "io/transform/landmarks.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"
#include "mesh/simplex_mesh.h"
#include "session/scene.h"
#include "session/undo_history.h"
#include "step/simulation_parameters.h"

namespace simplexseg::test {

inline void fuzz_volume(const std::filesystem::path& path) {
  const LoadedVolume loaded = load_volume(path);
  loaded.volume.range();
}
/// Reads a mesh; an accepted mesh must be valid.
inline void fuzz_mesh(const std::filesystem::path& path) { validate(read_mesh(path)); }
inline void fuzz_state(const std::filesystem::path& path) {
  MeshItem item;
  item.mesh = make_sphere({0, 0, 0}, 10, 0);
  restore_pose_state("state", small_file(path), item);
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
  std::string bytes = small_file(path);
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

/// Reads a model of organs. Its checksum is corrected first, as that of a history.
inline void fuzz_model(const std::filesystem::path& path) {
  std::string bytes = small_file(path);
  try {
    expect_plain_cbor(bytes);
    nlohmann::json file = nlohmann::json::from_cbor(bytes);
    const auto& contents = file.at("contents").get_binary();
    const uLong checksum = crc32_z(0, contents.data(), contents.size());
    char text[64];
    std::snprintf(text, sizeof text, "crc32-%08lx-%zu", checksum, contents.size());
    file["checksum"] = text;
    bytes.clear();
    nlohmann::json::to_cbor(file, bytes);
  } catch (const std::exception&) {  // not the outer structure of a model: read as it is
  }
  const ModelFile model = model_from_bytes(bytes, "model");
  model_bytes(model);
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
    {"model", "fuzzed.model", fuzz_model},
    {"tfm", "fuzzed.tfm", [](const std::filesystem::path& path) { read_transform(path); }},
    {"matlab", "fuzzed.mat", [](const std::filesystem::path& path) { read_transform(path); }},
    {"field", "fuzzed.nii", [](const std::filesystem::path& path) { read_transform(path); }},
    {"landmarks", "fuzzed.csv", [](const std::filesystem::path& path) { read_landmarks(path); }},
    {"cases", "fuzzed.csv", [](const std::filesystem::path& path) { read_case_table(path); }},
    {"labels", "fuzzed.json", [](const std::filesystem::path& path) { read_label_preset(path); }},
};

}  // namespace simplexseg::test
