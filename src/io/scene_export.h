// SPDX-License-Identifier: Apache-2.0
// What comes out of a scene, for other programs: one exporter for the window and the command line.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/picture_io.h"
#include "session/scene.h"

namespace simplexseg {

/// Throws Error where save_labels() would for the name, or since the scene's volume is not what a DICOM file needs.
void require_labels_name(const std::filesystem::path& path, const Scene& scene);

/// Writes what the meshes of a scene are inside of, by the name of the file: NAME.rtstruct.dcm their contours on the
/// slices of the scene's volume, which is a DICOM image (write_rtstruct()); any other the voxels of the grid, each with
/// the label of its mesh, .dcm as a segmentation of that image (write_dicom_segmentation()), the rest as
/// write_labels(). Returns a line for the user where voxels lie inside several meshes or labels have other numbers in
/// the file, else nothing. Throws Error as make_label_map() and these do.
std::string save_labels(const std::filesystem::path& path, const Scene& scene, const VolumeGeometry& geometry);

/// Throws Error where save_view() would for the name, or since the scene's volume is not what a DICOM file needs.
void require_view_name(const std::filesystem::path& path, const Scene& scene);

/// Writes a picture of a scene: .dcm as a secondary capture in the study of the scene's volume, which is a DICOM image
/// (write_secondary_capture()); any other as write_picture(). Throws Error as these do.
void save_view(const std::filesystem::path& path, const Picture& picture, const Scene& scene);

/// The names of the files that save_meshes() writes, in the order of the scene's meshes: those of the meshes where they
/// can be file names (distinct_file_names()), with the extension.
std::vector<std::string> mesh_file_names(const Scene& scene, const std::string& extension = ".ply");

/// Writes each mesh of a scene as a file of its own into the folder, which must exist; files of these names are
/// replaced. `extension`: one of write_mesh()'s. Returns the files. Throws Error as write_mesh() does.
std::vector<std::filesystem::path> save_meshes(const std::filesystem::path& folder, const Scene& scene,
                                               const std::string& extension = ".ply");

}  // namespace simplexseg
