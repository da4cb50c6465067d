// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/segment_names.h"

namespace simplexseg {

constexpr int kMostVolumes = 1000000;  ///< numbers of volumes that can be asked for

/// What a volume file (or a folder with a DICOM series) says of itself, known without reading the voxels.
struct VolumeInfo {
  VolumeGeometry geometry;  ///< LPS, mm
  /// The type the voxels have once read (rescaled files: float or a wider integer); in DICOM shifted 16-bit integers
  /// are Int32 instead of Int16 where a value needs it.
  VoxelType type = VoxelType::UInt8;
  std::string format;                 ///< "NIfTI-1", "DICOM series", "NRRD" ...
  int components = 1;                 ///< values per voxel; only 1 can be read
  int frames = 1;                     ///< volumes in the file (4D)
  int frame = 0;                      ///< which of several volumes is read, from 1; 0: there is one, or none can be
  bool low_is_bright = false;         ///< low values are meant to be shown bright (MONOCHROME1)
  int file_count = 1;                 ///< files the voxels come from
  std::vector<SegmentName> segments;  ///< of labels that have names in their file
  std::vector<std::string> warnings;  ///< one line each: what the reader had to assume, and what it left out
};

struct LoadedVolume {
  Volume volume;
  std::string format;
  int frames = 1;              ///< volumes in the file (4D)
  int frame = 0;               ///< which of several volumes this is, from 1; 0: there is one
  bool low_is_bright = false;  ///< low values are meant to be shown bright (MONOCHROME1)
  bool is_dicom = false;       ///< made of DICOM images, to which files of DICOM can refer
  std::vector<SegmentName> segments;
  std::string patient, series;        ///< names, of DICOM; empty where it has none
  std::vector<std::string> warnings;  ///< as in VolumeInfo, and what was seen in the voxels
};

/// Describes NIfTI (.nii, .nii.gz, .hdr/.img), Analyze, MetaImage, NRRD, GIPL (.gipl, .gipl.gz), MINC, one DICOM
/// file, or a folder that holds a DICOM series (the files may have any name; of several series the largest is taken,
/// with a warning). Throws Error when there is no such file, it is none of these, its geometry cannot be used, or the
/// file is too small for what its header claims. Of a 4D file or series number `volume` is described, from 1.
/// `series`: UID of the series that is taken of a DICOM folder, searched in its subfolders where the folder itself has
/// it not; what of it makes no volume is left out with a warning (open_named_series()).
VolumeInfo read_volume_info(const std::filesystem::path& path, int volume = 1, const std::string& series = {});
/// How many volumes of a file or folder load_volume() can load: more than 1 where it is 4D. Throws Error as
/// read_volume_info does.
int count_volumes(const std::filesystem::path& path);

/// Reads the voxels in their own type (64-bit integers are narrowed to 32 bits where the values allow it); of a 4D file
/// or series those of number `volume`, from 1, which is a warning. Throws Error as read_volume_info does, and for
/// colour, a number that there is not, truncated files, a DICOM series with missing, doubled or differently oriented
/// slices, and a volume that does not fit into the memory available.
LoadedVolume load_volume(const std::filesystem::path& path, int volume = 1, const std::string& series = {});

/// Throws the Error of load_volume() for colour, and for 4D whose volumes cannot be told apart.
void require_one_value(const std::filesystem::path& path, const VolumeInfo& info);

/// load_volume() without the warnings.
Volume read_volume(const std::filesystem::path& path);

/// Throws Error where write_volume() would for the extension.
void require_volume_name(const std::filesystem::path& path);
/// Writes .nii, .nii.gz, .nrrd or .mha, voxels and type as they are; written beside and renamed, so that `path` is
/// never half a file. Throws Error for another extension, an empty volume, a folder that does not exist, or a failed
/// write.
void write_volume(const std::filesystem::path& path, const Volume& volume);
/// The same for a label volume; .seg.nrrd has the names and colours too (of other labels than `names` numbers). Throws
/// Error besides when the voxels are not integers.
void write_labels(const std::filesystem::path& path, const Volume& labels, const std::vector<SegmentName>& names = {});

/// Bytes of memory that can be had without swapping, as the system says (/proc/meminfo); 0 where it does not say.
std::size_t available_memory();

}  // namespace simplexseg
