// SPDX-License-Identifier: Apache-2.0
#include "io/scene/scene_export.h"

#include <algorithm>

#include "core/number_text.h"
#include "io/dicom_write/dicom_capture_write.h"
#include "io/dicom_write/dicom_seg_write.h"
#include "io/dicom_write/rtstruct_write.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/data_path.h"
#include "io/platform/file_names.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/scene/label_preset.h"
#include "io/scene/scene_text.h"
#include "io/volume/volume_io.h"
#include "session/label_map.h"
#include "session/paint.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// Name, colour and codes of each label; the names of meshes with the same label are joined.
std::vector<SegmentName> names_of(const Scene& scene) {
  std::vector<SegmentName> names;
  for (const MeshItem& item : scene.meshes) {
    const auto same = std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.value == item.label; });
    if (same == names.end())
      names.push_back({item.label, item.name, item.colour, code_of(item)});
    else
      same->name += ", " + item.name;
  }
  return names;
}

bool is_dicom_name(const fs::path& path) { return extension_of(path) == ".dcm"; }
bool is_structure_name(const fs::path& path) {
  return lower_ascii(path.filename().string()).ends_with(".rtstruct.dcm");
}
bool is_label_map_name(const fs::path& path) {
  return lower_ascii(path.filename().string()).ends_with(".labelmap.dcm");
}

void add_overlap_note(std::string& note, const LabelMap& map) {
  if (map.shared_voxels > 0)
    note += (note.empty() ? "" : "; ") +
            counted(static_cast<std::int64_t>(map.shared_voxels), "voxel lies", "voxels lie") +
            " inside two or more segmentations; each is assigned to the most probable one, or else to the first";
}

}  // namespace

DicomSource source_of(const Scene& scene, const fs::path& target) {
  return read_dicom_source(scene.volume_path.empty() ? fs::path() : find_data(scene.volume_path, {}), target,
                           scene.volume_number, scene.volume_series);
}

WrittenSegmentation save_segmentation(const fs::path& path, const Scene& scene, const VolumeGeometry& geometry,
                                      SegmentEncoding encoding) {
  const LabelMap map = make_label_map(scene, geometry);
  WrittenSegmentation written =
      write_dicom_segmentation(path, map.labels, names_of(scene), source_of(scene, path), encoding);
  add_overlap_note(written.note, map);
  return written;
}

void require_labels_name(const fs::path& path) {
  if (!is_dicom_name(path)) require_volume_name(path);
}

void require_labels_name(const fs::path& path, const Scene& scene) {
  require_labels_name(path);
  if (is_dicom_name(path) && scene.meshes.empty())
    throw Error("cannot write " + quoted(path), "the scene has no segmentation", "create one first");
  if (!is_structure_name(path)) require_label_numbers(scene);
  if (is_dicom_name(path)) source_of(scene, path);
}

std::string save_labels(const fs::path& path, const Scene& scene, const VolumeGeometry& geometry) {
  return save_labels(path, scene, geometry, geometry);
}

std::string save_labels(const fs::path& path, const Scene& scene, const VolumeGeometry& geometry,
                        const VolumeGeometry& volume) {
  if (is_dicom_name(path) && !geometry.same_grid(volume))
    throw Error("cannot write " + quoted(path), "DICOM labels need the grid of their image",
                "write another format, or omit the other grid");
  if (is_structure_name(path)) {
    std::vector<SegmentCode> codes;
    for (const MeshItem& item : scene.meshes) codes.push_back(code_of(item));
    write_rtstruct(path, scene, codes, source_of(scene, path));
    return "";
  }
  if (is_dicom_name(path)) {
    const bool is_label_map = is_label_map_name(path);
    return save_segmentation(path, scene, geometry, is_label_map ? SegmentEncoding::LabelMap : SegmentEncoding::Binary)
        .note;
  }
  const LabelMap map = make_label_map(scene, geometry, volume);
  std::string note = write_labels(path, map.labels, names_of(scene));
  add_overlap_note(note, map);
  return note;
}

void require_view_name(const fs::path& path) {
  if (!is_dicom_name(path)) require_picture_name(path);
}

void require_view_name(const fs::path& path, const Scene& scene) {
  require_view_name(path);
  if (is_dicom_name(path)) source_of(scene, path);
}

void require_scene_name(const fs::path& path) {
  if (path.extension() != ".json")
    throw Error("cannot write " + quoted(path), "the name of a scene ends in .json", "rename it to NAME.json");
}

void require_scene_name(const fs::path& path, const Scene& scene) {
  require_scene_name(path);
  scene_text(path, scene, std::vector<std::string>(scene.meshes.size(), path.stem().string()));
}

void save_view(const fs::path& path, const Picture& picture, const Scene& scene) {
  if (is_dicom_name(path))
    write_secondary_capture(path, picture, "View of SimplexSeg", source_of(scene, path));
  else
    write_picture(path, picture);
}

std::vector<std::string> mesh_file_names(const Scene& scene, const std::string& extension) {
  std::vector<std::string> names;
  for (const MeshItem& item : scene.meshes) names.push_back(item.name);
  names = distinct_file_names(names, "mesh");
  for (std::string& name : names) name += extension;
  return names;
}

std::vector<fs::path> save_meshes(const fs::path& folder, const Scene& scene, const std::string& extension) {
  std::vector<fs::path> files;
  for (const std::string& name : mesh_file_names(scene, extension)) {
    const MeshItem& item = scene.meshes[files.size()];
    files.push_back(folder / name);
    if (holds_several_surfaces(name)) {
      const NamedSurface surface{item.name, item.colour, &item.mesh};
      write_surfaces(files.back(), {&surface, 1});
    } else {
      write_mesh(files.back(), item.mesh);
    }
  }
  return files;
}

void save_surfaces(const fs::path& path, const Scene& scene) {
  std::vector<NamedSurface> surfaces;
  for (const MeshItem& item : scene.meshes) surfaces.push_back({item.name, item.colour, &item.mesh});
  write_surfaces(path, surfaces);
}

void save_fractions(const fs::path& folder, const Scene& scene, const VolumeGeometry& grid) {
  const std::vector<std::string> names = mesh_file_names(scene, kFractionsExtension);
  for (std::size_t m = 0; m < names.size(); ++m) {
    const MeshItem& item = scene.meshes[m];
    Volume volume(grid, VoxelType::Float32);
    std::ranges::copy(object_fractions(item.mesh, paint_of(scene, item.id), grid), volume.voxels<float>().begin());
    write_volume(folder / names[m], volume);
  }
}

}  // namespace simplexseg
