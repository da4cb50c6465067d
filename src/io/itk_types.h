// SPDX-License-Identifier: Apache-2.0
// For the .cpp files of this folder that use ITK: its names for what is in VolumeInfo.
#pragma once
#include <itkImageIOBase.h>

#include <string>

#include "io/volume_io.h"

namespace simplexseg {

/// The type that voxels are kept in, and whether the file has them as 64-bit integers. Throws Error on another type.
struct ItkVoxels {
  VoxelType type;
  bool wide;
};
ItkVoxels itk_voxels_of(const itk::ImageIOBase& io, const std::string& name);

/// Takes geometry, frames and components from an `io` whose information is read.
void describe(const itk::ImageIOBase& io, VolumeInfo& info);
/// Reads all voxels to `to`, which has room for io.GetImageSizeInBytes().
void read_whole(itk::ImageIOBase& io, void* to);

}  // namespace simplexseg
