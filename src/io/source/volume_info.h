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
  /// Voxel type in memory. Rescaled files use float or a wider integer; DICOM volumes of shifted 16-bit integers can
  /// become Int32 on reading when a value does not fit into Int16.
  VoxelType type = VoxelType::UInt8;
  std::string format;                 ///< "NIfTI-1", "DICOM series", "NRRD" ...
  int components = 1;                 ///< values per voxel; only 1 can be read
  int frames = 1;                     ///< number of volumes (4D)
  int frame = 0;                      ///< selected volume of several, from 1; 0: only one, or none can be read
  bool low_is_bright = false;         ///< low values are displayed bright (MONOCHROME1)
  int file_count = 1;                 ///< number of files with voxels
  std::vector<SegmentName> segments;  ///< named labels
  std::vector<std::string> warnings;  ///< assumptions of the reader and omitted data, one line each
};

/// Throws Error for volumes with several values per voxel, and for 4D files whose interleaving cannot be read.
void require_one_value(const std::filesystem::path& path, const VolumeInfo& info);

}  // namespace simplexseg
