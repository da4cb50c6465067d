// SPDX-License-Identifier: Apache-2.0
// Reader for NIfTI and Analyze files that does not use ITK. ITK's reader rejects sheared sforms, pads truncated files
// with zeros, does not support NIfTI-2 and copies the voxels; its writer makes a sheared geometry orthogonal.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Opens a NIfTI-1, NIfTI-2 or Analyze 7.5 volume, compressed with gzip or not, in a single file or a pair .hdr/.img.
/// `volume`: number in a 4D file, from 1. Throws Error for an invalid header, a file that is too small, or an invalid
/// volume number.
VolumeSource open_nifti(const std::filesystem::path& path, int volume = 1);
/// Vectors of a NIfTI file with three components along its fifth dimension.
struct NiftiVectors {
  VolumeGeometry grid;
  std::vector<Eigen::Vector3f> vectors;  ///< of each voxel, i fastest
  int intent = 0;                        ///< code of the header, e.g. 1007 (vector)
};
/// Reads vectors. Throws Error like open_nifti(), and for a file without three components of floating-point numbers.
NiftiVectors read_nifti_vectors(const std::filesystem::path& path);
/// Whether the file, decompressed if necessary, begins with a header of NIfTI-1 or NIfTI-2 (not Analyze).
bool is_nifti_file(const std::filesystem::path& path);

}  // namespace simplexseg
