// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/source/segment_names.h"

namespace simplexseg {

constexpr int kMaxVolumes = 1000000;  ///< highest volume number that can be requested

/// Header data of a volume file or a DICOM series; available without reading the voxels.
struct VolumeInfo {
  VolumeGeometry geometry;  ///< LPS, mm
  /// Voxel type in memory. Rescaled volumes use a floating-point type or, in DICOM, an integer type that contains the
  /// rescaled values. DICOM volumes of 16-bit integers with an intercept change from Int16 to Int32 on reading when a
  /// value does not fit into Int16.
  VoxelType type = VoxelType::UInt8;
  std::string format;  ///< "NIfTI-1", "DICOM series", "NRRD" ...
  int components = 1;  ///< values per voxel; only 1 can be read
  int frames = 1;      ///< number of volumes (4D)
  /// Time of each volume of a 4D file or series, s; empty if it is not stated.
  std::vector<double> times_s{};
  int frame = 0;                      ///< number of the selected volume, from 1; 0: only one, or none can be read
  bool low_is_bright = false;         ///< low values are displayed bright (MONOCHROME1)
  int file_count = 1;                 ///< number of files with voxels
  std::vector<SegmentName> segments;  ///< names and colours of label values
  std::vector<std::string> warnings;  ///< assumptions of the reader and omitted data, one line each
};

/// Throws Error for volumes with several values per voxel, and for 4D files whose interleaving cannot be read.
void require_one_value(const std::filesystem::path& path, const VolumeInfo& info);

}  // namespace simplexseg
