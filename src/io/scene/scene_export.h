// SPDX-License-Identifier: Apache-2.0
// Export of a scene for other programs, for the window and the command line.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom_write/dicom_seg_write.h"
#include "io/picture/picture_io.h"
#include "session/scene.h"

namespace simplexseg {

/// Throws Error if save_labels() does not support the file name.
void require_labels_name(const std::filesystem::path& path);
/// Throws the errors of save_labels() that the file name and the scene determine before a run: another format, a DICOM
/// file for a volume that is not DICOM or for a scene without meshes, a label outside 1 to 65535.
void require_labels_name(const std::filesystem::path& path, const Scene& scene);

/// DICOM images of the volume of a scene, for a file `target` that refers to them. Throws the errors of
/// read_dicom_source().
DicomSource source_of(const Scene& scene, const std::filesystem::path& target);
/// Writes the segmentations of a scene as DICOM segmentation on the grid of its DICOM volume. The note for the user of
/// save_labels() is in the result. Throws the errors of make_label_map() and write_dicom_segmentation().
WrittenSegmentation save_segmentation(const std::filesystem::path& path, const Scene& scene,
                                      const VolumeGeometry& geometry, SegmentEncoding encoding);

/// Writes the segmentations of a scene in the format of the file name. NAME.rtstruct.dcm: contours on the slices of the
/// DICOM volume (write_rtstruct()); NAME.labelmap.dcm and other .dcm: a DICOM segmentation, as label map or binary
/// (write_dicom_segmentation()); other extensions: a label volume on the grid `geometry` (write_labels()). Returns a
/// note for the user if segmentations overlap in voxels, labels are renumbered or the grid is sheared, else "". Throws
/// the errors of make_label_map() and of these writers.
std::string save_labels(const std::filesystem::path& path, const Scene& scene, const VolumeGeometry& geometry);
/// Label volume on a grid other than that of the volume, whose grid is `volume`. Throws Error for a .dcm file, which
/// needs the grid of its image.
std::string save_labels(const std::filesystem::path& path, const Scene& scene, const VolumeGeometry& geometry,
                        const VolumeGeometry& volume);

/// Throws Error if save_view() does not support the file name.
void require_view_name(const std::filesystem::path& path);
/// Throws the errors of require_view_name() above, and Error if a DICOM file is requested for a volume that is not
/// DICOM.
void require_view_name(const std::filesystem::path& path, const Scene& scene);

/// Throws Error if the file name of a scene does not end in .json.
void require_scene_name(const std::filesystem::path& path);
/// Throws the errors of require_scene_name() above, and those of scene_text() for this scene, for example for a path
/// that is not UTF-8.
void require_scene_name(const std::filesystem::path& path, const Scene& scene);

/// Writes a picture of a scene: a .dcm file as a secondary capture in the study of the DICOM volume
/// (write_secondary_capture()), other files with write_picture(). Throws the errors of these writers.
void save_view(const std::filesystem::path& path, const Picture& picture, const Scene& scene);

/// Names of the files that save_meshes() writes, in the order of the meshes: names of the meshes, converted by
/// distinct_file_names(), with the extension.
std::vector<std::string> mesh_file_names(const Scene& scene, const std::string& extension = ".ply");

/// Writes each mesh of a scene to a separate file in an existing folder; replaces existing files. `extension`: one that
/// write_mesh() supports. Returns the paths. Throws the errors of write_mesh().
std::vector<std::filesystem::path> save_meshes(const std::filesystem::path& folder, const Scene& scene,
                                               const std::string& extension = ".ply");

/// Writes all meshes of a scene, with names and colours, to one file (write_surfaces()). Throws its errors.
void save_surfaces(const std::filesystem::path& path, const Scene& scene);

/// Extension of the files of save_fractions().
inline constexpr const char* kFractionsExtension = ".nii.gz";
/// Writes partial-volume labels: for each mesh of a scene the fraction of each voxel of a grid inside it
/// (object_fractions(), float32, 0..1), to NAME.nii.gz in an existing folder. Throws the errors of write_volume().
void save_fractions(const std::filesystem::path& folder, const Scene& scene, const VolumeGeometry& grid);

}  // namespace simplexseg
