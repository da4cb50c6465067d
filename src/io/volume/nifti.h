// SPDX-License-Identifier: Apache-2.0
// NIfTI and Analyze without ITK. ITK's reader rejects sheared sforms, pads truncated files with zeros, does not support
// NIfTI-2 and copies the voxels; its writer makes a sheared geometry orthogonal.
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Opens a NIfTI-1, NIfTI-2 or Analyze 7.5 file, compressed with gzip or not, a single file or a pair .hdr/.img.
/// Throws Error for an invalid header or a file that is too small.
VolumeSource open_nifti(const std::filesystem::path& path, int volume = 1);
/// Whether the file, decompressed if necessary, begins with a NIfTI header.
bool is_nifti_file(const std::filesystem::path& path);

}  // namespace simplexseg
