// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Whether a file, compressed or not, has the magic number of GIPL. Throws Error when it cannot be opened.
bool is_gipl_file(const std::filesystem::path& path);

/// Opens a GIPL file (Guy's Image Processing Lab), compressed with gzip or not. Sizes and origin are in mm; programs do
/// not agree on an orientation, so a warning is added. Throws Error for an invalid header or a file that is too small.
VolumeSource open_gipl(const std::filesystem::path& path, int volume = 1);

}  // namespace simplexseg
