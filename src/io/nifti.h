// SPDX-License-Identifier: Apache-2.0
// NIfTI and Analyze, read without ITK: its reader refuses sheared sforms, fills what a truncated file lacks with zeros,
// knows no NIfTI-2 and copies the voxels; its writer makes a sheared geometry orthogonal.
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

/// NIfTI-1, NIfTI-2 and Analyze 7.5, plain or gzip'ed, one file or .hdr/.img.
VolumeSource open_nifti(const std::filesystem::path& path, int volume = 1);
/// True when the first bytes (of the unpacked file) are those of a NIfTI file.
bool looks_like_nifti(const std::filesystem::path& path);

}  // namespace simplexseg
