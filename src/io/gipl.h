// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

/// Whether a file, packed or not, has the number in it that GIPL files have. Throws Error when it cannot be opened.
bool looks_like_gipl(const std::filesystem::path& path);

/// Opens GIPL (Guy's image processing lab), packed by gzip or not. It has sizes and an origin in mm but no orientation
/// that programs agree on, which is a warning. Throws Error for a header that cannot be used or voxels that the file
/// cannot hold.
VolumeSource open_gipl(const std::filesystem::path& path, int volume = 1);

}  // namespace simplexseg
