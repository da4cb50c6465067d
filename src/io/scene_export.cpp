// SPDX-License-Identifier: Apache-2.0
#include "io/scene_export.h"

#include <algorithm>

#include "io/file_names.h"
#include "io/mesh_io.h"
#include "io/volume_io.h"
#include "session/label_map.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// One for each label: meshes that share one share their names.
std::vector<SegmentName> names_of(const Scene& scene) {
  std::vector<SegmentName> names;
  for (const MeshItem& item : scene.meshes) {
    const auto same = std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.value == item.label; });
    if (same == names.end())
      names.push_back({item.label, item.name, item.colour});
    else
      same->name += ", " + item.name;
  }
  return names;
}

}  // namespace

std::string save_labels(const fs::path& path, const Scene& scene, const VolumeGeometry& geometry) {
  const LabelMap map = make_label_map(scene, geometry);
  write_labels(path, map.labels, names_of(scene));
  if (map.shared_voxels == 0) return "";
  return std::to_string(map.shared_voxels) +
         " voxels lie inside two or more meshes; the one whose field is surer of them, else the first, has them";
}

std::vector<std::string> mesh_file_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const MeshItem& item : scene.meshes) names.push_back(item.name);
  names = distinct_file_names(names, "mesh");
  for (std::string& name : names) name += ".ply";
  return names;
}

std::vector<fs::path> save_meshes(const fs::path& folder, const Scene& scene) {
  std::vector<fs::path> files;
  for (const std::string& name : mesh_file_names(scene)) {
    files.push_back(folder / name);
    write_mesh(files.back(), scene.meshes[files.size() - 1].mesh);
  }
  return files;
}

}  // namespace simplexseg
