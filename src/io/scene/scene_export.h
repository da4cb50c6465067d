// SPDX-License-Identifier: Apache-2.0
// Export of a scene for other programs, for the window and the command line.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/picture/picture_io.h"
#include "session/scene.h"

namespace simplexseg {

/// Throws Error if save_labels() does not support the file name, or a DICOM file is requested for a volume that is not
/// DICOM.
void require_labels_name(const std::filesystem::path& path, const Scene& scene);

/// Writes the segmentations of a scene in the format of the file name: NAME.rtstruct.dcm contours on the slices of the
/// DICOM volume (write_rtstruct()); .dcm a DICOM segmentation (write_dicom_segmentation()); others a label volume on
/// the grid (write_labels()). Returns a note for the user if segmentations overlap or labels are renumbered, else "".
/// Throws the errors of make_label_map() and of these writers.
std::string save_labels(const std::filesystem::path& path, const Scene& scene, const VolumeGeometry& geometry);

/// Throws Error if save_view() does not support the file name, or a DICOM file is requested for a volume that is not
/// DICOM.
void require_view_name(const std::filesystem::path& path, const Scene& scene);

/// Writes a picture of a scene: .dcm as a secondary capture in the study of the DICOM volume
/// (write_secondary_capture()), others by write_picture(). Throws the errors of these writers.
void save_view(const std::filesystem::path& path, const Picture& picture, const Scene& scene);

/// File names that save_meshes() writes, in the order of the meshes: the names of the meshes, converted by
/// distinct_file_names(), with the extension.
std::vector<std::string> mesh_file_names(const Scene& scene, const std::string& extension = ".ply");

/// Writes each mesh of a scene to a separate file in an existing folder, replacing existing files. `extension`:
/// extension supported by write_mesh(). Returns the paths. Throws the errors of write_mesh().
std::vector<std::filesystem::path> save_meshes(const std::filesystem::path& folder, const Scene& scene,
                                               const std::string& extension = ".ply");

}  // namespace simplexseg
