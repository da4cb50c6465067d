// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom/uptake.h"
#include "io/source/segment_names.h"
#include "io/source/volume_info.h"

namespace simplexseg {

struct VolumeSource;  // io/source/volume_source.h

/// A volume in memory with the metadata of its file.
struct LoadedVolume {
  Volume volume;
  std::string format;
  int frames = 1;              ///< number of volumes in the file (4D)
  int frame = 0;               ///< number of this volume, from 1; 0 if the file contains only one
  bool low_is_bright = false;  ///< low values are displayed bright (MONOCHROME1)
  bool is_dicom = false;       ///< read from a DICOM image, so DICOM output can refer to it
  std::vector<SegmentName> segments;
  std::string patient, series;        ///< DICOM patient name, else patient ID; series description; empty if missing
  std::string intensity_unit;         ///< "HU" for CT in DICOM, "Bq/ml" for PET; empty if unknown
  UptakeScale uptake;                 ///< PET in DICOM: factor to SUVbw, or the reason why there is none
  std::vector<std::string> warnings;  ///< warnings of VolumeInfo and about voxel values, one line each
};

/// Reads the header of a volume: NIfTI (.nii, .nii.gz, .hdr/.img), Analyze, MetaImage, NRRD, GIPL (.gipl, .gipl.gz),
/// MINC, a DICOM file, or a folder with a DICOM series. The largest of several series is used, with a warning.
/// `volume`: number of the volume in a 4D file or series, from 1. `series`: UID of the series to read from a DICOM
/// folder or its subfolders. Throws Error if the file is missing or too small, its format is not supported, its
/// geometry is invalid, or it has no volume of that number.
VolumeInfo read_volume_info(const std::filesystem::path& path, int volume = 1, const std::string& series = {});
/// Opens a file or folder for reading. Arguments and errors are those of read_volume_info().
VolumeSource open_volume(const std::filesystem::path& path, int volume = 1, const std::string& series = {});

/// Number of volumes in a file or folder that load_volume() can read; more than 1 if it is 4D. Throws the errors of
/// read_volume_info().
int count_volumes(const std::filesystem::path& path);

/// Reads a volume in its voxel type; integers that the file scales become floating-point numbers, 64-bit integers
/// become 32-bit integers. Reading one volume of a 4D file adds a warning. Throws the errors of read_volume_info(), and
/// Error for colour images, 64-bit values that need more than 32 bits, truncated files, a DICOM series with missing,
/// duplicate or differently oriented slices, and too little memory. Throws Cancelled (LoadProgress).
LoadedVolume load_volume(const std::filesystem::path& path, int volume = 1, const std::string& series = {});

/// Reads the volume that open_volume() opened as `path`. `segment`: number of the segment that is read alone, without
/// the others that share its voxels; requires VolumeSource::read_segment. Errors are those of load_volume().
LoadedVolume load_volume(const VolumeSource& source, const std::filesystem::path& path,
                         std::optional<int> segment = std::nullopt);

/// Reads a volume with load_volume(), without metadata and warnings.
Volume read_volume(const std::filesystem::path& path);

/// Throws Error if write_volume() does not support the extension.
void require_volume_name(const std::filesystem::path& path);
/// Writes .nii, .nii.gz, .nrrd or .mha with unchanged voxels and voxel type. A grid that was read from a file of the
/// same format is stated as in that file (VolumeGeometry::header). Writes a temporary file and renames it, so that
/// `path` is never incomplete. Returns a warning for the user if the grid is sheared, else "". Throws Error for another
/// extension, an empty volume, a missing folder, or a failed write.
std::string write_volume(const std::filesystem::path& path, const Volume& volume);
/// Writes a label volume with write_volume(). A .seg.nrrd file also stores names and colours; a label that is not in
/// `names` is named "label NUMBER". Returns the warning of write_volume(). Throws the errors of write_volume(), and
/// Error if the voxels are not integers.
std::string write_labels(const std::filesystem::path& path, const Volume& labels,
                         const std::vector<SegmentName>& names = {});

/// Memory available without swapping (MemAvailable in /proc/meminfo), bytes; 0 if unknown.
std::size_t available_memory();

}  // namespace simplexseg
